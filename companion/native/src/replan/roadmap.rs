//! A sparse graph over the whole map, made when there is time, for paths around what a changed map has closed.
//!
//! Edges were valid when they were made. On another map they count as valid until they lie on the best path, and are
//! only then checked (in the manner of Lazy PRM, Bohlin and Kavraki 2000), exactly and once for each map.

use std::collections::BinaryHeap;

use crate::geometry::{distance, distance_squared, path_length, Point};
use crate::lattice::queue::Entry;
use crate::map::field::Field;
use crate::replan::elastic;

/// How many of the nearest nodes a new node is connected to.
const MAX_NEIGHBOURS: usize = 6;
/// Inserted nodes above which all of them are removed before more are inserted.
const MAX_INSERTED: usize = 2_000;

/// What is known of an edge on the map as it is.
#[derive(Clone, Copy, PartialEq)]
enum EdgeStatus {
    Unchecked,
    Valid,
    /// Valid when it leads from end to end through this point instead.
    Bent(Point),
    Invalid,
}

/// What is known of a node on the map as it is.
#[derive(Clone, Copy, PartialEq)]
enum NodeStatus {
    Unchecked,
    At(Point),
    Invalid,
}

struct Edge {
    ends: [u32; 2],
    /// Metres, on the map on which it was made.
    length: f64,
    /// Metres, on the map as it is.
    now: f64,
    /// What lies between the ends, from the first to the second.
    inner: Vec<Point>,
    status: EdgeStatus,
    /// The number of the map of which `status` and `now` speak.
    map: u32,
}

/// A node of an inserted path.
#[derive(Clone, Copy)]
pub struct PathNode {
    /// Its number in the roadmap.
    pub node: usize,
    /// The edge from the node before; meaningless for the first one.
    pub edge: usize,
    /// The number of the path's vertex that it is, or else that comes after it.
    pub next: usize,
    /// It is a vertex of the path.
    pub vertex: bool,
}

/// A path in the graph: a node at every vertex, and more where these lie far apart.
struct InsertedPath {
    line: Vec<Point>,
    nodes: Vec<PathNode>,
}

/// Distances of all nodes from a goal, on the map on which the graph was made.
struct GoalDistances {
    goal: Point,
    distances: Vec<f64>,
}

/// Nodes, edges, and what is known of them on the map as it is.
pub struct Roadmap {
    points: Vec<Point>,
    /// Where the nodes are, each on the map of this number.
    nodes: Vec<(u32, NodeStatus)>,
    /// The number of the map as it is.
    map: u32,
    edges: Vec<Edge>,
    /// Per node its neighbours, each with the edge that leads there.
    adjacent: Vec<Vec<(u32, u32)>>,
    radius: f64,
    /// Metres between nodes, about.
    spacing: f64,
    /// How many nodes and edges are permanent; those of inserted paths come after them.
    permanent: (usize, usize),
    inserted: Vec<InsertedPath>,
    goal_distances: Vec<GoalDistances>,
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
            adjacent: vec![Vec::new(); points.len()],
            nodes: vec![(0, NodeStatus::Unchecked); points.len()],
            map: 1,
            permanent: (points.len(), edges.len()),
            points,
            edges: Vec::new(),
            radius,
            spacing,
            inserted: Vec::new(),
            goal_distances: Vec::new(),
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
            status: EdgeStatus::Unchecked,
            map: self.map,
        });
        self.adjacent[ends[0] as usize].push((ends[1], edge));
        self.adjacent[ends[1] as usize].push((ends[0], edge));
    }

    /// Makes ready for another map: nothing is known of it.
    pub fn begin_map(&mut self) {
        self.map += 1;
    }

    /// Nodes and edges.
    pub fn size(&self) -> (usize, usize) {
        (self.points.len(), self.edges.len())
    }

    /// A node's neighbours over edges that are not known to be invalid, each with its edge and that edge's length.
    pub fn neighbours(&self, node: usize) -> impl Iterator<Item = (usize, usize, f64)> + use<'_> {
        self.adjacent[node].iter().filter_map(|&(next, edge)| {
            let found = &self.edges[edge as usize];
            let (status, length) = if found.map == self.map {
                (found.status, found.now)
            } else {
                (EdgeStatus::Unchecked, found.length)
            };
            (status != EdgeStatus::Invalid).then_some((next as usize, edge as usize, length))
        })
    }

    /// Where a node is on this map: where it was, or a little aside when something stands there.
    fn check_node<F: Field>(&mut self, field: &F, node: usize) -> Option<Point> {
        if self.nodes[node].0 != self.map {
            let found = elastic::shift(field, self.points[node], self.spacing, self.radius);
            self.nodes[node] = (self.map, found.map_or(NodeStatus::Invalid, NodeStatus::At));
        }
        match self.nodes[node].1 {
            NodeStatus::At(p) => Some(p),
            _ => None,
        }
    }

    /// True when the edge is valid on this map, if need be with its ends shifted or bent.
    pub fn check_edge<F: Field>(&mut self, field: &F, edge: usize) -> bool {
        let found = &mut self.edges[edge];
        if found.map != self.map {
            (found.map, found.status, found.now) = (self.map, EdgeStatus::Unchecked, found.length);
        }
        if found.status == EdgeStatus::Unchecked {
            let ends = self.edges[edge].ends;
            let [from, to] = ends.map(|end| self.check_node(field, end as usize));
            let found = &mut self.edges[edge];
            found.status = EdgeStatus::Invalid;
            if let (Some(from), Some(to)) = (from, to) {
                let clear = |a: Point, b: Point| field.edge_clear(a, b, self.radius);
                let mut at = from;
                let as_made = found.inner.iter().chain([&to]).all(|&next| {
                    let clear = clear(at, next);
                    at = next;
                    clear
                });
                if as_made {
                    found.status = EdgeStatus::Valid;
                } else if let Some(p) = elastic::bend(field, (from, to), self.spacing, self.radius)
                {
                    found.status = EdgeStatus::Bent(p);
                    found.now = distance(from, p) + distance(p, to);
                }
            }
        }
        self.edges[edge].status != EdgeStatus::Invalid
    }

    /// Where a node is on this map, as far as it has been checked.
    pub fn point(&self, node: usize) -> Point {
        match self.nodes[node] {
            (map, NodeStatus::At(p)) if map == self.map => p,
            _ => self.points[node],
        }
    }

    /// True when a valid edge is as it was made.
    pub fn unchanged(&self, edge: usize) -> bool {
        let found = &self.edges[edge];
        found.status == EdgeStatus::Valid
            && (found.ends.iter()).all(|&end| self.point(end as usize) == self.points[end as usize])
    }

    /// Notes that the edge is known to be valid on this map.
    pub fn mark_valid(&mut self, edge: usize) {
        let found = &mut self.edges[edge];
        (found.map, found.status, found.now) = (self.map, EdgeStatus::Valid, found.length);
    }

    /// Length of a checked edge in metres.
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
        if let EdgeStatus::Bent(p) = self.edges[edge].status {
            return vec![p];
        }
        let mut inner = inner.clone();
        if ends[0] as usize == end {
            inner.reverse();
        }
        inner
    }

    /// Adds a node at `p`, connected to the nearest ones by straight unchecked edges.
    pub fn add_node(&mut self, p: Point) -> usize {
        let mut near: Vec<u32> = (0..self.points.len() as u32).collect();
        let key = |node: &u32| distance_squared(self.points[*node as usize], p);
        let by_distance = |a: &u32, b: &u32| key(a).total_cmp(&key(b)).then(a.cmp(b));
        if near.len() > MAX_NEIGHBOURS {
            near.select_nth_unstable_by(MAX_NEIGHBOURS - 1, by_distance);
            near.truncate(MAX_NEIGHBOURS);
        }
        near.sort_unstable_by(by_distance);
        let node = self.points.len();
        self.points.push(p);
        self.nodes.push((0, NodeStatus::Unchecked));
        self.adjacent.push(Vec::new());
        for other in near {
            self.connect([node as u32, other], Vec::new());
        }
        for known in &mut self.goal_distances {
            if known.goal == p {
                known.distances.push(0.0);
                continue;
            }
            let least = (self.adjacent[node].iter())
                .map(|&(next, edge)| {
                    known.distances[next as usize] + self.edges[edge as usize].length
                })
                .fold(f64::INFINITY, f64::min);
            known.distances.push(least);
        }
        node
    }

    /// The nodes of `line` in the graph, inserted if they are not there yet.
    pub fn insert_path(&mut self, line: &[Point]) -> Vec<PathNode> {
        if let Some(known) = self.inserted.iter().find(|inserted| inserted.line == line) {
            return known.nodes.clone();
        }
        if self.points.len() > self.permanent.0 + MAX_INSERTED {
            self.remove_inserted();
        }
        let mut nodes: Vec<PathNode> = Vec::new();
        for (next, &to) in line.iter().enumerate() {
            let from = line[next.saturating_sub(1)];
            let pieces = (distance(from, to) / self.spacing).ceil().max(1.0) as usize;
            for piece in 1..=pieces {
                let vertex = piece == pieces;
                let p = from.towards(to, piece as f64 / pieces as f64);
                let node = self.add_node(if vertex { to } else { p });
                let edge = self.edges.len();
                if let Some(before) = nodes.last() {
                    self.connect([before.node as u32, node as u32], Vec::new());
                }
                nodes.push(PathNode {
                    node,
                    edge,
                    next,
                    vertex,
                });
            }
        }
        self.inserted.push(InsertedPath {
            line: line.to_vec(),
            nodes: nodes.clone(),
        });
        nodes
    }

    /// Removes all inserted paths.
    fn remove_inserted(&mut self) {
        let (nodes, edges) = self.permanent;
        self.points.truncate(nodes);
        self.nodes.truncate(nodes);
        self.adjacent.truncate(nodes);
        self.edges.truncate(edges);
        for adjacent in &mut self.adjacent {
            adjacent.retain(|&(_, edge)| (edge as usize) < edges);
        }
        for known in &mut self.goal_distances {
            known.distances.truncate(nodes);
        }
        self.inserted.clear();
    }

    /// Checks every edge on the map as it is, drops the invalid ones, and computes the distance of every node from `goals`.
    pub fn revalidate<F: Field>(&mut self, field: &F, goals: &[Point]) {
        for edge in 0..self.edges.len() {
            if !self.check_edge(field, edge) {
                for end in self.edges[edge].ends {
                    self.adjacent[end as usize].retain(|&(_, other)| other as usize != edge);
                }
            }
            let found = &mut self.edges[edge];
            if let EdgeStatus::Bent(p) = found.status {
                (found.inner, found.length) = (vec![p], found.now);
            }
        }
        self.goal_distances = Vec::new();
        for &goal in goals {
            if let Some(node) = self.points.iter().position(|&p| p == goal) {
                let distances = self.distances(node);
                self.goal_distances.push(GoalDistances { goal, distances });
            }
        }
    }

    /// The number by which `cost_to_go` knows the goal at this node, if it does.
    pub fn known_goal(&self, node: usize) -> Option<usize> {
        let goal = self.points[node];
        self.goal_distances
            .iter()
            .position(|known| known.goal == goal)
    }

    /// Estimated metres from `node` to `goal`: those of the map on which the graph was made where they are known, or else
    /// a straight line.
    pub fn cost_to_go(&self, known: Option<usize>, node: usize, goal: usize) -> f64 {
        match known {
            Some(known) => self.goal_distances[known].distances[node],
            None => distance(self.points[node], self.points[goal]),
        }
    }

    /// Distances from `node` over edges that are not invalid; infinite where there is no path.
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
            for (next, _, length) in self.neighbours(index) {
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
