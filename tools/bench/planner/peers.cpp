// Peers of the planner in C++, timed in this process: grid A* with shortcuts and exact ordering, and OMPL where its
// headers are (-DWITH_OMPL). Reads one task from stdin, prints one line per run: method seed milliseconds length nodes.
//
//   grid: columns rows resolution radius, cells as one string of 0 and 1; circles: count, then x y r;
//   stops: count, then x y, the start first; order seeds milliseconds_per_leg. Order 0: as given, 1: any, 2: every two
//   stops are a task of their own, and a seed is the number of the task.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <limits>
#include <queue>
#include <string>
#include <vector>

#ifdef WITH_OMPL
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/base/objectives/PathLengthOptimizationObjective.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/informedtrees/BITstar.h>
#include <ompl/geometric/planners/rrt/RRT.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>
#endif

struct Point { double x, y; };
struct Circle { double x, y, r; };
using Path = std::vector<Point>;

static int columns, rows, order, seeds;
static double resolution, radius, leg_ms, width, height;
static std::vector<unsigned char> blocked, steps;
static const int STEP[8][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
static std::vector<Circle> circles;
static std::vector<Point> stops;

static double apart(Point a, Point b) { return std::hypot(a.x - b.x, a.y - b.y); }
static double now() {  // processor time in milliseconds: others who are busy on the machine do not count
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e3 * t.tv_sec + 1e-6 * t.tv_nsec;
}
static double since(double begin) { return now() - begin; }

static double to_segment(Point p, Point a, Point b) {  // squared
  const double dx = b.x - a.x, dy = b.y - a.y, l2 = dx * dx + dy * dy;
  const double t = l2 > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / l2, 0.0, 1.0) : 0.0;
  const double ex = a.x + t * dx - p.x, ey = a.y + t * dy - p.y;
  return ex * ex + ey * ey;
}

static double to_square(Point p, int column, int row) {  // squared
  const double dx = std::max({column * resolution - p.x, p.x - (column + 1) * resolution, 0.0});
  const double dy = std::max({row * resolution - p.y, p.y - (row + 1) * resolution, 0.0});
  return dx * dx + dy * dy;
}

// The rover's own rule: no blocked square is nearer to the segment than the radius. Pieces of a cell's length, so that
// samples every tenth of a cell find a piece that runs through a square.
static bool swept(Point a, Point b) {
  const double reach = std::max(radius - 1e-9, 0.0);
  const int pieces = std::max(1, (int)std::ceil(apart(a, b) / resolution));
  for (int i = 0; i < pieces; ++i) {
    const double s = (double)i / pieces, t = (double)(i + 1) / pieces;
    const Point p{a.x + s * (b.x - a.x), a.y + s * (b.y - a.y)}, q{a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)};
    const double low = std::min({p.x, p.y, q.x, q.y});
    const double high = std::min({width - p.x, width - q.x, height - p.y, height - q.y});
    if (std::min(low, high) < radius - 1e-9) return false;
    const int left = std::max((int)((std::min(p.x, q.x) - radius) / resolution), 0);
    const int right = std::min((int)((std::max(p.x, q.x) + radius) / resolution), columns - 1);
    const int bottom = std::max((int)((std::min(p.y, q.y) - radius) / resolution), 0);
    const int top = std::min((int)((std::max(p.y, q.y) + radius) / resolution), rows - 1);
    for (int r = bottom; r <= top; ++r)
      for (int c = left; c <= right; ++c) {
        if (!blocked[r * columns + c]) continue;
        double nearest = std::min(to_square(p, c, r), to_square(q, c, r));
        for (int corner = 0; corner < 4; ++corner)
          nearest = std::min(nearest, to_segment({(c + corner % 2) * resolution, (r + corner / 2) * resolution}, p, q));
        for (int k = 1; k < 10; ++k)
          nearest = std::min(nearest, to_square({p.x + 0.1 * k * (q.x - p.x), p.y + 0.1 * k * (q.y - p.y)}, c, r));
        if (nearest < reach * reach) return false;
      }
  }
  return true;
}

static Point centre(int cell) { return {(cell % columns + 0.5) * resolution, (cell / columns + 0.5) * resolution}; }

// The map that an A* is given: per cell a bit for each step to a neighbour on which the robot fits, by the same rule.
static void inflate() {
  std::vector<float> clear(columns * rows, std::numeric_limits<float>::infinity());
  const int reach = (int)std::ceil(radius / resolution) + 1;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      if (!blocked[row * columns + column]) continue;
      for (int dy = -reach; dy <= reach; ++dy)
        for (int dx = -reach; dx <= reach; ++dx) {
          const int c = column + dx, r = row + dy;
          if (c < 0 || r < 0 || c >= columns || r >= rows) continue;
          const float gx = std::max(std::abs(dx) - 0.5, 0.0) * resolution;
          const float gy = std::max(std::abs(dy) - 0.5, 0.0) * resolution;
          clear[r * columns + c] = std::min(clear[r * columns + c], gx * gx + gy * gy);
        }
    }
  steps.assign(columns * rows, 0);
  for (int cell = 0; cell < columns * rows; ++cell)
    for (int d = 0; d < 8 && clear[cell] >= radius * radius; ++d) {
      const int c = cell % columns + STEP[d][0], r = cell / columns + STEP[d][1];
      if (c < 0 || r < 0 || c >= columns || r >= rows) continue;
      const int next = r * columns + c;
      const double half = 0.25 * resolution * resolution * (d < 4 ? 1 : 2);
      const Point a = centre(cell), b = centre(next);
      const double wall = std::min({a.x, a.y, b.x, b.y, width - a.x, width - b.x, height - a.y, height - b.y});
      const float least = std::min(clear[cell], clear[next]);
      if (wall < radius - 1e-9 || least < radius * radius) continue;
      if (least >= radius * radius + half || swept(a, b)) steps[cell] |= 1 << d;
    }
}

static double length(const Path& path) {
  double sum = 0;
  for (size_t i = 1; i < path.size(); ++i) sum += apart(path[i - 1], path[i]);
  return sum;
}

static Path a_star(Point from, Point to, long& nodes) {
  const int start = (int)(from.y / resolution) * columns + (int)(from.x / resolution);
  const int goal = (int)(to.y / resolution) * columns + (int)(to.x / resolution);
  const int gc = goal % columns, gr = goal / columns;
  std::vector<float> cost(columns * rows, std::numeric_limits<float>::infinity());
  std::vector<int> parent(columns * rows, -1);
  auto ahead = [&](int cell) {
    const int dx = std::abs(cell % columns - gc), dy = std::abs(cell / columns - gr);
    return (float)(std::max(dx, dy) + 0.41421356 * std::min(dx, dy));
  };
  std::priority_queue<std::pair<float, int>, std::vector<std::pair<float, int>>, std::greater<>> open;
  cost[start] = 0;
  open.push({ahead(start), start});
  std::vector<bool> closed(columns * rows, false);
  while (!open.empty()) {
    const int at = open.top().second;
    open.pop();
    if (closed[at]) continue;
    closed[at] = true;
    ++nodes;
    if (at == goal) break;
    const int c = at % columns, r = at / columns;
    for (int d = 0; d < 8; ++d) {
      if (!(steps[at] >> d & 1)) continue;
      const int next = (r + STEP[d][1]) * columns + c + STEP[d][0];
      const float through = cost[at] + (d < 4 ? 1.0f : 1.41421356f);
      if (through < cost[next]) {
        cost[next] = through;
        parent[next] = at;
        open.push({through + ahead(next), next});
      }
    }
  }
  Path path;
  if (!std::isfinite(cost[goal])) return path;
  for (int at = goal; at != -1; at = parent[at])
    path.push_back(centre(at));
  std::reverse(path.begin(), path.end());
  return path;
}

static Path shortcut(const Path& path) {  // from each vertex on to the farthest that it sees
  Path kept{path.front()};
  for (size_t at = 0; at + 1 < path.size();) {
    size_t next = path.size() - 1;
    while (next > at + 1 && !swept(path[at], path[next])) --next;
    kept.push_back(path[at = next]);
  }
  return kept;
}

static std::vector<int> exact_order(const std::vector<std::vector<double>>& legs) {
  const int n = (int)legs.size() - 1, full = 1 << n;
  std::vector<double> best((size_t)full * n, 1e300);
  std::vector<int> from((size_t)full * n, -1);
  for (int g = 0; g < n; ++g) best[(1 << g) * n + g] = legs[0][g + 1];
  for (int set = 1; set < full; ++set)
    for (int last = 0; last < n; ++last)
      if (set >> last & 1)
        for (int next = 0; next < n; ++next)
          if (!(set >> next & 1)) {
            const double through = best[set * n + last] + legs[last + 1][next + 1];
            const int slot = (set | 1 << next) * n + next;
            if (through < best[slot]) best[slot] = through, from[slot] = last;
          }
  int last = 0, set = full - 1;
  for (int g = 1; g < n; ++g)
    if (best[set * n + g] < best[set * n + last]) last = g;
  std::vector<int> order;
  while (last >= 0) {
    order.push_back(last + 1);
    const int before = from[set * n + last];
    set &= ~(1 << last);
    last = before;
  }
  std::reverse(order.begin(), order.end());
  return order;
}

static void run_a_star(bool with_shortcuts, int seed) {
  const auto begin = now();
  const int n = (int)stops.size();
  long nodes = 0;
  double total = 0;
  auto leg = [&](int a, int b) {
    Path path = a_star(stops[a], stops[b], nodes);
    if (path.empty()) return std::numeric_limits<double>::infinity();
    return length(with_shortcuts ? shortcut(path) : path);
  };
  if (order == 1) {
    std::vector<std::vector<double>> legs(n, std::vector<double>(n, 0));
    for (int a = 0; a < n; ++a)
      for (int b = a + 1; b < n; ++b) legs[a][b] = legs[b][a] = leg(a, b);
    int at = 0;
    for (int next : exact_order(legs)) total += legs[at][next], at = next;
  } else {
    for (int a = 0; a + 1 < n; ++a) total += leg(a, a + 1);
  }
  std::printf("%s %d %.4f %.5f %ld\n", with_shortcuts ? "a-star-shortcuts" : "a-star", seed, since(begin), total, nodes);
}

#ifdef WITH_OMPL
namespace ob = ompl::base;
namespace og = ompl::geometric;

struct Sweep : ob::MotionValidator {  // exact for circles, as the rover's own check
  explicit Sweep(const ob::SpaceInformationPtr& si) : ob::MotionValidator(si) {}
  bool checkMotion(const ob::State* s, const ob::State* t) const override {
    const double* a = s->as<ob::RealVectorStateSpace::StateType>()->values;
    const double* b = t->as<ob::RealVectorStateSpace::StateType>()->values;
    const double dx = b[0] - a[0], dy = b[1] - a[1], l2 = dx * dx + dy * dy;
    for (const Circle& c : circles) {
      const double u = l2 > 0 ? std::clamp(((c.x - a[0]) * dx + (c.y - a[1]) * dy) / l2, 0.0, 1.0) : 0.0;
      const double ex = a[0] + u * dx - c.x, ey = a[1] + u * dy - c.y, reach = radius + c.r;
      if (ex * ex + ey * ey < reach * reach) return false;
    }
    return true;
  }
  bool checkMotion(const ob::State* a, const ob::State* b, std::pair<ob::State*, double>&) const override {
    return checkMotion(a, b);
  }
};

template <class Planner>
static void run_ompl(const char* name, bool first_only) {
  for (int seed = 0; seed < seeds; ++seed) {
    double total = 0, spent = 0;
    unsigned nodes = 0;
    for (size_t leg = 0; leg + 1 < stops.size(); ++leg) {
      auto space = std::make_shared<ob::RealVectorStateSpace>(2);
      ob::RealVectorBounds bounds(2);
      bounds.setLow(radius);
      bounds.setHigh(0, width - radius);
      bounds.setHigh(1, height - radius);
      space->setBounds(bounds);
      og::SimpleSetup setup(space);
      auto si = setup.getSpaceInformation();
      auto sweep = std::make_shared<Sweep>(si);
      si->setMotionValidator(sweep);
      setup.setStateValidityChecker([sweep](const ob::State* s) { return sweep->checkMotion(s, s); });
      ob::ScopedState<> from(space), to(space);
      from[0] = stops[leg].x, from[1] = stops[leg].y, to[0] = stops[leg + 1].x, to[1] = stops[leg + 1].y;
      setup.setStartAndGoalStates(from, to);
      auto objective = std::make_shared<ob::PathLengthOptimizationObjective>(si);
      if (first_only) objective->setCostThreshold(ob::Cost(1e9));
      setup.setOptimizationObjective(objective);
      auto planner = std::make_shared<Planner>(si);
      setup.setPlanner(planner);
      setup.setup();
      const auto begin = now();
      setup.solve((first_only ? 10000.0 : leg_ms) * 1e-3);
      spent += since(begin);
      total += setup.haveExactSolutionPath() ? setup.getSolutionPath().length() : 1e9;
      ob::PlannerData data(si);
      planner->getPlannerData(data);
      nodes += data.numVertices();
    }
    std::printf("%s %d %.4f %.5f %u\n", name, seed, spent, total, nodes);
  }
}
#endif

int main() {
  std::string cells;
  int count;
  std::cin >> columns >> rows >> resolution >> radius >> cells >> count;
  width = columns * resolution, height = rows * resolution;
  circles.resize(count);
  for (Circle& c : circles) std::cin >> c.x >> c.y >> c.r;
  std::cin >> count;
  stops.resize(count);
  for (Point& p : stops) std::cin >> p.x >> p.y;
  std::cin >> order >> seeds >> leg_ms;
  if (!std::cin) return 2;
  blocked.resize(columns * rows);
  for (int cell = 0; cell < columns * rows; ++cell) blocked[cell] = cells[cell] == '1';
  const auto begin = now();
  inflate();
  std::printf("inflation 0 %.4f 0 0\n", since(begin));
  if (order == 2) {
    const std::vector<Point> all = stops;
    for (size_t task = 0; task + 1 < all.size(); task += 2) {
      stops = {all[task], all[task + 1]};
      run_a_star(false, task / 2);
      run_a_star(true, task / 2);
    }
    return 0;
  }
  run_a_star(false, 0);
  run_a_star(true, 0);
#ifdef WITH_OMPL
  ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
  if (seeds > 0) {
    ompl::RNG::setSeed(1);
    run_ompl<og::RRT>("ompl-rrt", true);
    run_ompl<og::RRTConnect>("ompl-rrt-connect", true);
    run_ompl<og::RRTstar>("ompl-rrt-star-first", true);
    run_ompl<og::RRTstar>("ompl-rrt-star", false);
    run_ompl<og::BITstar>("ompl-bit-star", false);
  }
#endif
  return 0;
}
