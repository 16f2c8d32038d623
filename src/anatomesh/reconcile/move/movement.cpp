#include "anatomesh/reconcile/move/movement.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>

namespace anatomesh {

namespace {

// A group's position is pulled to its usual value by so little that it decides only where nothing else does.
// [mm; > 0; D]
constexpr double pull_to_usual = 1e-4;
// It stands for a node that is held, and so is no unknown. [index; 2^32 - 1; D]
constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
// Conjugate gradients end after so many steps, wherever they are. [steps; >= 1; B]
constexpr int most_gradient_steps = 1000;
// They end where the residual is this share of the first one. [1; 0 to 1; B]
constexpr double gradient_precision = 1e-5;

// Holds the chains of free nodes, each with two edges, between the other nodes. The movements of a chain
// follow from those of the two nodes at its ends, so its energy is a quadratic form in these alone.
// Gaussian elimination along the chain is stable, because all pivots are sums of positive terms.
class Chains {
  public:
    // Two nodes that are not in a chain: the energy has the term -coupling * (movement of a) * (movement
    // of b).
    struct Link {
        std::uint32_t a = 0, b = 0;
        double coupling = 0;
    };

    Chains(const std::vector<MovementNode>& nodes, const std::vector<MovementEdge>& edges, double smoothing)
        : edges_(edges), square_(smoothing * smoothing), diagonal_(nodes.size(), 0.0) {
        std::vector<std::uint32_t> degree(nodes.size(), 0);
        for (const MovementEdge& edge : edges) {
            for (const std::uint32_t n : {edge.a, edge.b}) {
                diagonal_[n] += 0.5 * edge.length;
                ++degree[n];
            }
        }
        inside_.resize(nodes.size());
        for (std::size_t n = 0; n < nodes.size(); ++n)
            inside_[n] = nodes[n].hold == Hold::free && degree[n] == 2;
        list_edges(degree);
        std::vector<std::uint8_t> seen(edges.size(), 0);
        for (std::uint32_t n = 0; n < nodes.size(); ++n) {
            for (std::uint32_t k = first_edge_[n]; !inside_[n] && k < first_edge_[n + 1]; ++k) {
                if (!seen[edges_of_node_[k]]) eliminate(n, edges_of_node_[k], seen);
            }
        }
    }

    // A node that is not inside a chain has a weight for its own squared movement.
    bool is_inside(std::size_t node) const { return inside_[node] != 0; }
    double diagonal(std::size_t node) const { return diagonal_[node]; }
    const std::vector<Link>& links() const { return links_; }

    // Fills in the movements inside the chains from those of the other nodes. Rings of free nodes alone do
    // not move.
    void fill(std::vector<Vec2>& moves) const {
        for (std::size_t c = 0; c < links_.size(); ++c) {
            const std::uint32_t begin = first_step_[c];
            Vec2 after = moves[links_[c].b];
            for (std::uint32_t k = first_step_[c + 1]; k-- > begin;) {
                const Step& step = steps_[k];
                after =
                    (step.to_start / step.pivot) * moves[links_[c].a] + (step.to_next / step.pivot) * after;
                moves[step.node] = after;
            }
        }
    }

  private:
    // A node of a chain, after those before it were eliminated.
    struct Step {
        std::uint32_t node = 0;
        double pivot = 0, to_start = 0, to_next = 0;  // its own weight, couplings
    };

    void list_edges(const std::vector<std::uint32_t>& degree) {
        first_edge_.assign(degree.size() + 1, 0);
        std::partial_sum(degree.begin(), degree.end(), first_edge_.begin() + 1);
        edges_of_node_.resize(first_edge_.back());
        std::vector<std::uint32_t> next(first_edge_.begin(), first_edge_.end() - 1);
        for (std::uint32_t e = 0; e < edges_.size(); ++e) {
            edges_of_node_[next[edges_[e].a]++] = e;
            edges_of_node_[next[edges_[e].b]++] = e;
        }
    }

    double stiffness(std::uint32_t edge) const { return square_ / edges_[edge].length; }

    // Eliminates the chain that starts at a node with an edge.
    void eliminate(std::uint32_t start, std::uint32_t edge, std::vector<std::uint8_t>& seen) {
        double coupling = stiffness(edge), here = coupling;  // of the node reached: to the start, its own
        diagonal_[start] += coupling;
        std::uint32_t node = start;
        for (;;) {
            seen[edge] = 1;
            node = edges_[edge].a == node ? edges_[edge].b : edges_[edge].a;
            if (!inside_[node]) break;
            const std::uint32_t* around = &edges_of_node_[first_edge_[node]];
            edge = around[0] == edge ? around[1] : around[0];
            const double to_next = stiffness(edge), pivot = diagonal_[node] + here + to_next;
            steps_.push_back({node, pivot, coupling, to_next});
            diagonal_[start] -= coupling * coupling / pivot;
            here = to_next - to_next * to_next / pivot;
            coupling *= to_next / pivot;
        }
        diagonal_[node] += here;
        links_.push_back({start, node, coupling});
        first_step_.push_back(static_cast<std::uint32_t>(steps_.size()));
    }

    const std::vector<MovementEdge>& edges_;
    const double square_;
    std::vector<double> diagonal_;
    std::vector<std::uint8_t> inside_;
    std::vector<std::uint32_t> first_edge_, edges_of_node_;
    std::vector<Link> links_;
    std::vector<Step> steps_;                   // by chain, from its start
    std::vector<std::uint32_t> first_step_{0};  // by chain
};

// Holds the energy as a function of the unknowns that are left: movements of free nodes where chains meet,
// and positions of groups relative to the usual ones.
class Energy {
  public:
    Energy(const std::vector<MovementNode>& nodes, const Chains& chains, const std::vector<double>& usual)
        : nodes_(nodes), chains_(chains), usual_(usual), moves_(nodes.size()), forces_(nodes.size()) {
        for (std::uint32_t n = 0; n < nodes.size(); ++n) {
            if (!chains.is_inside(n)) ends_.push_back(n);
        }
        unknown_.assign(nodes.size(), none);
        for (const std::uint32_t n : ends_) {
            if (nodes[n].hold != Hold::free) continue;
            unknown_[n] = count_;
            count_ += 2;
        }
    }

    std::size_t size() const { return count_ + usual_.size(); }

    // Returns the movement of all nodes except those inside chains. With `affine` it includes that of
    // pinned nodes and of the usual positions.
    std::vector<Vec2>& spread(const std::vector<double>& x, bool affine) {
        for (const std::uint32_t n : ends_) {
            const MovementNode& node = nodes_[n];
            if (node.hold == Hold::free) {
                moves_[n] = {x[unknown_[n]], x[unknown_[n] + 1]};
            } else if (node.hold == Hold::pinned) {
                moves_[n] = affine ? node.direction : Vec2{};
            } else {
                const double offset = affine ? usual_[node.group] - node.place : 0;
                moves_[n] = (x[count_ + node.group] + offset) * node.direction;
            }
        }
        return moves_;
    }

    // Computes the gradient by the unknowns at x.
    void gradient(const std::vector<double>& x, bool affine, std::vector<double>& out) {
        spread(x, affine);
        for (const std::uint32_t n : ends_) forces_[n] = chains_.diagonal(n) * moves_[n];
        for (const Chains::Link& link : chains_.links()) {
            forces_[link.a] = forces_[link.a] - link.coupling * moves_[link.b];
            forces_[link.b] = forces_[link.b] - link.coupling * moves_[link.a];
        }
        out.assign(size(), 0.0);
        for (std::size_t g = 0; g < usual_.size(); ++g) out[count_ + g] = pull_to_usual * x[count_ + g];
        for (const std::uint32_t n : ends_) {
            const MovementNode& node = nodes_[n];
            if (node.hold == Hold::free) {
                out[unknown_[n]] = forces_[n].x;
                out[unknown_[n] + 1] = forces_[n].y;
            } else if (node.hold == Hold::anchor) {
                out[count_ + node.group] += dot(node.direction, forces_[n]);
            }
        }
    }

    std::vector<double> inverse_diagonal() const {
        std::vector<double> diagonal(size(), 1.0);
        for (std::size_t g = 0; g < usual_.size(); ++g) diagonal[count_ + g] = pull_to_usual;
        for (const std::uint32_t n : ends_) {
            const MovementNode& node = nodes_[n];
            const double weight = chains_.diagonal(n);
            if (node.hold == Hold::free && weight > 0)
                diagonal[unknown_[n]] = diagonal[unknown_[n] + 1] = weight;
            if (node.hold == Hold::anchor)
                diagonal[count_ + node.group] += weight * squared_length(node.direction);
        }
        for (double& d : diagonal) d = 1 / d;
        return diagonal;
    }

  private:
    const std::vector<MovementNode>& nodes_;
    const Chains& chains_;
    const std::vector<double>& usual_;
    std::vector<std::uint32_t> ends_, unknown_;  // nodes outside chains; per node: its first unknown
    std::uint32_t count_ = 0;
    std::vector<Vec2> moves_, forces_;
};

double product(const std::vector<double>& x, const std::vector<double>& y) {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += x[i] * y[i];
    return sum;
}

}  // namespace

std::vector<Vec2> solve_movement(const std::vector<MovementNode>& nodes,
                                 const std::vector<MovementEdge>& edges, const std::vector<double>& usual,
                                 double smoothing) {
    const Chains chains(nodes, edges, smoothing);
    Energy energy(nodes, chains, usual);
    const std::vector<double> inverse = energy.inverse_diagonal();
    std::vector<double> x(energy.size(), 0.0), residual, direction, product_with;
    energy.gradient(x, true, residual);
    for (double& r : residual) r = -r;
    std::vector<double> scaled(energy.size());
    const auto precondition = [&] {
        for (std::size_t i = 0; i < scaled.size(); ++i) scaled[i] = inverse[i] * residual[i];
        return product(residual, scaled);
    };
    double square = precondition();
    const double enough = gradient_precision * gradient_precision * square;
    direction = scaled;
    for (int step = 0; step < most_gradient_steps && square > enough; ++step) {
        energy.gradient(direction, false, product_with);
        const double curvature = product(direction, product_with);
        if (!(curvature > 0)) break;
        const double length = square / curvature;
        for (std::size_t i = 0; i < x.size(); ++i) {
            x[i] += length * direction[i];
            residual[i] -= length * product_with[i];
        }
        const double next = precondition(), ratio = next / square;
        square = next;
        for (std::size_t i = 0; i < x.size(); ++i) direction[i] = scaled[i] + ratio * direction[i];
    }
    std::vector<Vec2> moves = energy.spread(x, true);
    chains.fill(moves);
    return moves;
}

}  // namespace anatomesh
