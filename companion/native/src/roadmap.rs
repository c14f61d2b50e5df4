//! A sparse graph over the whole ground, made when there is time, for ways around what a changed map has closed.
//!
//! Edges were valid when they were made. On another map they are taken on trust until they lie on the best way, and are
//! only then checked (in the manner of Lazy PRM, Bohlin and Kavraki 2000), exactly and once for each map.

use std::collections::BinaryHeap;

use crate::dijkstra::Entry;
use crate::elastic;
use crate::field::Field;
use crate::geometry::{distance, distance_squared, path_length, Point};

/// How many of the nearest nodes a point is joined to.
const JOINS: usize = 6;
/// Nodes beside those of the ground above which they are dropped before more are laid.
const MOST_LAID: usize = 2_000;

/// What is known of an edge on the map as it is.
#[derive(Clone, Copy, PartialEq)]
enum Check {
    Due,
    Clear,
    /// Clear when it leads from end to end through this point instead.
    Bent(Point),
    Cut,
}

/// What is known of a node on the map as it is.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Due,
    At(Point),
    Nowhere,
}

struct Edge {
    ends: [u32; 2],
    /// As it was made, or as it is where it is bent.
    length: f64,
    now: f64,
    /// What lies between the ends, from the first to the second.
    inner: Vec<Point>,
    check: Check,
    /// The map on which that holds.
    map: u32,
}

/// A node of a leg in the graph.
#[derive(Clone, Copy)]
pub struct Post {
    pub node: usize,
    /// The edge from the post before; the first post has none.
    pub edge: usize,
    /// The number of the leg's vertex that it is, or else that comes after it.
    pub next: usize,
    pub vertex: bool,
}

/// A leg in the graph: a post at every vertex, and more where these lie far apart.
struct Laid {
    line: Vec<Point>,
    posts: Vec<Post>,
}

/// Distances of all nodes from a goal, on the map on which the graph was made.
struct Aim {
    goal: Point,
    distances: Vec<f64>,
}

pub struct Roadmap {
    points: Vec<Point>,
    /// Where the nodes are, each on the map of this number.
    places: Vec<(u32, Place)>,
    /// The number of the map as it is.
    map: u32,
    edges: Vec<Edge>,
    /// Per node the nodes beside it, each with the edge that leads there.
    beside: Vec<Vec<(u32, u32)>>,
    pub radius: f64,
    /// Distance between nodes, about.
    spacing: f64,
    /// How many nodes and edges the ground itself has.
    ground: (usize, usize),
    laid: Vec<Laid>,
    aims: Vec<Aim>,
}

impl Roadmap {
    /// A graph of these nodes and of edges between them, each with what lies between its ends.
    pub fn new(
        points: Vec<Point>,
        edges: Vec<([u32; 2], Vec<Point>)>,
        radius: f64,
        spacing: f64,
    ) -> Self {
        let mut roadmap = Self {
            beside: vec![Vec::new(); points.len()],
            places: vec![(0, Place::Due); points.len()],
            map: 1,
            ground: (points.len(), edges.len()),
            points,
            edges: Vec::new(),
            radius,
            spacing,
            laid: Vec::new(),
            aims: Vec::new(),
        };
        for (ends, inner) in edges {
            roadmap.connect(ends, inner);
        }
        roadmap
    }

    fn connect(&mut self, ends: [u32; 2], inner: Vec<Point>) {
        let [a, b] = ends.map(|end| self.points[end as usize]);
        let length = path_length(&[&[a], &inner[..], &[b]].concat());
        let edge = self.edges.len() as u32;
        self.edges.push(Edge {
            ends,
            length,
            now: length,
            inner,
            check: Check::Due,
            map: self.map,
        });
        self.beside[ends[0] as usize].push((ends[1], edge));
        self.beside[ends[1] as usize].push((ends[0], edge));
    }

    /// For another map: nothing is known of it.
    pub fn forget(&mut self) {
        self.map += 1;
    }

    /// Nodes and edges.
    pub fn size(&self) -> (usize, usize) {
        (self.points.len(), self.edges.len())
    }

    /// The nodes beside one that are not known to be cut off from it, each with its edge and that edge's length.
    pub fn around(&self, node: usize) -> impl Iterator<Item = (usize, usize, f64)> + use<'_> {
        self.beside[node].iter().filter_map(|&(next, edge)| {
            let found = &self.edges[edge as usize];
            let (check, length) = if found.map == self.map {
                (found.check, found.now)
            } else {
                (Check::Due, found.length)
            };
            (check != Check::Cut).then_some((next as usize, edge as usize, length))
        })
    }

    /// Where a node is on this map: where it was, or a little aside when something stands there.
    fn place<F: Field>(&mut self, field: &F, node: usize) -> Option<Point> {
        if self.places[node].0 != self.map {
            let found = elastic::place(field, self.points[node], self.spacing, self.radius);
            self.places[node] = (self.map, found.map_or(Place::Nowhere, Place::At));
        }
        match self.places[node].1 {
            Place::At(p) => Some(p),
            _ => None,
        }
    }

    /// True when the edge holds on this map, if need be with its ends aside and bent.
    pub fn holds<F: Field>(&mut self, field: &F, edge: usize) -> bool {
        let found = &mut self.edges[edge];
        if found.map != self.map {
            (found.map, found.check, found.now) = (self.map, Check::Due, found.length);
        }
        if found.check == Check::Due {
            let ends = self.edges[edge].ends;
            let [from, to] = ends.map(|end| self.place(field, end as usize));
            let found = &mut self.edges[edge];
            found.check = Check::Cut;
            if let (Some(from), Some(to)) = (from, to) {
                let clear = |a: Point, b: Point| field.edge_clear(a, b, self.radius);
                let mut at = from;
                let as_made = found.inner.iter().chain([&to]).all(|&next| {
                    let clear = clear(at, next);
                    at = next;
                    clear
                });
                if as_made {
                    found.check = Check::Clear;
                } else if let Some(p) = elastic::bend(field, (from, to), self.spacing, self.radius)
                {
                    found.check = Check::Bent(p);
                    found.now = distance(from, p) + distance(p, to);
                }
            }
        }
        self.edges[edge].check != Check::Cut
    }

    /// Where a node is on this map, if anybody has asked.
    pub fn at(&self, node: usize) -> Point {
        match self.places[node] {
            (map, Place::At(p)) if map == self.map => p,
            _ => self.points[node],
        }
    }

    /// True when an edge that holds is as it was made.
    pub fn unchanged(&self, edge: usize) -> bool {
        let found = &self.edges[edge];
        found.check == Check::Clear
            && (found.ends.iter()).all(|&end| self.at(end as usize) == self.points[end as usize])
    }

    /// Says that the edge is known to hold on this map.
    pub fn vouch(&mut self, edge: usize) {
        let found = &mut self.edges[edge];
        (found.map, found.check, found.now) = (self.map, Check::Clear, found.length);
    }

    pub fn length(&self, edge: usize) -> f64 {
        self.edges[edge].now
    }

    /// The end of an edge that is not `node`.
    pub fn far_end(&self, edge: usize, node: usize) -> usize {
        let [a, b] = self.edges[edge].ends.map(|end| end as usize);
        if a == node {
            b
        } else {
            a
        }
    }

    /// What lies between the ends of an edge, on the way to `end`.
    pub fn inner(&self, edge: usize, end: usize) -> Vec<Point> {
        let Edge { ends, inner, .. } = &self.edges[edge];
        if let Check::Bent(p) = self.edges[edge].check {
            return vec![p];
        }
        let mut inner = inner.clone();
        if ends[0] as usize == end {
            inner.reverse();
        }
        inner
    }

    /// A node at `p`, joined to the nearest ones by straight edges that nobody has checked.
    pub fn join(&mut self, p: Point) -> usize {
        let mut near: Vec<u32> = (0..self.points.len() as u32).collect();
        let key = |node: &u32| distance_squared(self.points[*node as usize], p);
        let by_distance = |a: &u32, b: &u32| key(a).total_cmp(&key(b)).then(a.cmp(b));
        if near.len() > JOINS {
            near.select_nth_unstable_by(JOINS - 1, by_distance);
            near.truncate(JOINS);
        }
        near.sort_unstable_by(by_distance);
        let node = self.points.len();
        self.points.push(p);
        self.places.push((0, Place::Due));
        self.beside.push(Vec::new());
        for other in near {
            self.connect([node as u32, other], Vec::new());
        }
        for aim in &mut self.aims {
            if aim.goal == p {
                aim.distances.push(0.0);
                continue;
            }
            let least = (self.beside[node].iter())
                .map(|&(next, edge)| {
                    aim.distances[next as usize] + self.edges[edge as usize].length
                })
                .fold(f64::INFINITY, f64::min);
            aim.distances.push(least);
        }
        node
    }

    /// The posts of `line` in the graph, laid there if they are not yet.
    pub fn lay(&mut self, line: &[Point]) -> Vec<Post> {
        if let Some(known) = self.laid.iter().find(|laid| laid.line == line) {
            return known.posts.clone();
        }
        if self.points.len() > self.ground.0 + MOST_LAID {
            self.clear();
        }
        let mut posts: Vec<Post> = Vec::new();
        for (next, &to) in line.iter().enumerate() {
            let from = line[next.saturating_sub(1)];
            let pieces = (distance(from, to) / self.spacing).ceil().max(1.0) as usize;
            for piece in 1..=pieces {
                let vertex = piece == pieces;
                let p = from.towards(to, piece as f64 / pieces as f64);
                let node = self.join(if vertex { to } else { p });
                let edge = self.edges.len();
                if let Some(before) = posts.last() {
                    self.connect([before.node as u32, node as u32], Vec::new());
                }
                posts.push(Post {
                    node,
                    edge,
                    next,
                    vertex,
                });
            }
        }
        self.laid.push(Laid {
            line: line.to_vec(),
            posts: posts.clone(),
        });
        posts
    }

    /// Takes out all that was laid.
    fn clear(&mut self) {
        let (nodes, edges) = self.ground;
        self.points.truncate(nodes);
        self.places.truncate(nodes);
        self.beside.truncate(nodes);
        self.edges.truncate(edges);
        for beside in &mut self.beside {
            beside.retain(|&(_, edge)| (edge as usize) < edges);
        }
        for aim in &mut self.aims {
            aim.distances.truncate(nodes);
        }
        self.laid.clear();
    }

    /// Learns on the map as it is which edges hold, forgets the others, and learns how far everything is from `goals`.
    pub fn survey<F: Field>(&mut self, field: &F, goals: &[Point]) {
        for edge in 0..self.edges.len() {
            if !self.holds(field, edge) {
                for end in self.edges[edge].ends {
                    self.beside[end as usize].retain(|&(_, other)| other as usize != edge);
                }
            }
            let found = &mut self.edges[edge];
            if let Check::Bent(p) = found.check {
                (found.inner, found.length) = (vec![p], found.now);
            }
        }
        self.aims = Vec::new();
        for &goal in goals {
            if let Some(node) = self.points.iter().position(|&p| p == goal) {
                let distances = self.distances(node);
                self.aims.push(Aim { goal, distances });
            }
        }
    }

    /// The number by which `ahead` knows where a node is, if it does.
    pub fn aim(&self, node: usize) -> Option<usize> {
        let goal = self.points[node];
        self.aims.iter().position(|aim| aim.goal == goal)
    }

    /// How far it is from `node` to `goal`, whose aim this is, at least, about: as it was where that is known, or else
    /// straight.
    pub fn ahead(&self, aim: Option<usize>, node: usize, goal: usize) -> f64 {
        match aim {
            Some(aim) => self.aims[aim].distances[node],
            None => distance(self.points[node], self.points[goal]),
        }
    }

    /// Distances from `node` over edges that are not cut; infinite where there is no way.
    fn distances(&self, node: usize) -> Vec<f64> {
        let mut distances = vec![f64::INFINITY; self.points.len()];
        distances[node] = 0.0;
        let mut heap = BinaryHeap::from([Entry {
            key: 0.0,
            index: node,
        }]);
        while let Some(Entry { key, index }) = heap.pop() {
            if key > distances[index] {
                continue;
            }
            for (next, _, length) in self.around(index) {
                if key + length < distances[next] {
                    distances[next] = key + length;
                    heap.push(Entry {
                        key: key + length,
                        index: next,
                    });
                }
            }
        }
        distances
    }
}
