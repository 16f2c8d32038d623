#include "anatomesh/reconcile/movement.h"

#include <cmath>
#include <cstddef>

namespace anatomesh {

namespace {

constexpr double pull_to_usual = 1e-4;  // of a group's position; the energy's unit is mm^3

// The quadratic energy in the unknowns: the movement of free nodes, then the groups' positions relative to
// the usual.
class Energy {
  public:
    Energy(const std::vector<MovementNode>& nodes, const std::vector<MovementEdge>& edges,
           const std::vector<double>& usual, double smoothing)
        : nodes_(nodes),
          edges_(edges),
          usual_(usual),
          square_(smoothing * smoothing),
          mass_(nodes.size(), 0.0),
          moves_(nodes.size()),
          forces_(nodes.size()) {
        for (const MovementEdge& edge : edges) {
            mass_[edge.a] += 0.5 * edge.length;
            mass_[edge.b] += 0.5 * edge.length;
        }
    }

    std::size_t size() const { return 2 * nodes_.size() + usual_.size(); }

    // The movement of all nodes; with `affine` that of pinned nodes and of the usual positions is in it.
    const std::vector<Vec2>& spread(const std::vector<double>& x, bool affine) {
        for (std::size_t n = 0; n < nodes_.size(); ++n) {
            const MovementNode& node = nodes_[n];
            if (node.hold == Hold::free) {
                moves_[n] = {x[2 * n], x[2 * n + 1]};
            } else if (node.hold == Hold::pinned) {
                moves_[n] = affine ? node.direction : Vec2{};
            } else {
                const double offset = affine ? usual_[node.group] - node.place : 0;
                moves_[n] = (x[2 * nodes_.size() + node.group] + offset) * node.direction;
            }
        }
        return moves_;
    }

    // The gradient by the unknowns at x.
    void gradient(const std::vector<double>& x, bool affine, std::vector<double>& out) {
        spread(x, affine);
        for (std::size_t n = 0; n < nodes_.size(); ++n) forces_[n] = mass_[n] * moves_[n];
        for (const MovementEdge& edge : edges_) {
            const Vec2 pull = (square_ / edge.length) * (moves_[edge.a] - moves_[edge.b]);
            forces_[edge.a] = forces_[edge.a] + pull;
            forces_[edge.b] = forces_[edge.b] - pull;
        }
        out.assign(size(), 0.0);
        for (std::size_t g = 0; g < usual_.size(); ++g) {
            out[2 * nodes_.size() + g] = pull_to_usual * x[2 * nodes_.size() + g];
        }
        for (std::size_t n = 0; n < nodes_.size(); ++n) {
            const MovementNode& node = nodes_[n];
            if (node.hold == Hold::free) {
                out[2 * n] = forces_[n].x;
                out[2 * n + 1] = forces_[n].y;
            } else if (node.hold == Hold::anchor) {
                out[2 * nodes_.size() + node.group] += dot(node.direction, forces_[n]);
            }
        }
    }

    std::vector<double> inverse_diagonal() const {
        std::vector<double> stiffness = mass_;
        for (const MovementEdge& edge : edges_) {
            stiffness[edge.a] += square_ / edge.length;
            stiffness[edge.b] += square_ / edge.length;
        }
        std::vector<double> diagonal(size(), 1.0);
        for (std::size_t g = 0; g < usual_.size(); ++g) diagonal[2 * nodes_.size() + g] = pull_to_usual;
        for (std::size_t n = 0; n < nodes_.size(); ++n) {
            const MovementNode& node = nodes_[n];
            if (node.hold == Hold::free && stiffness[n] > 0)
                diagonal[2 * n] = diagonal[2 * n + 1] = stiffness[n];
            if (node.hold == Hold::anchor) {
                diagonal[2 * nodes_.size() + node.group] += stiffness[n] * squared_length(node.direction);
            }
        }
        for (double& d : diagonal) d = 1 / d;
        return diagonal;
    }

  private:
    const std::vector<MovementNode>& nodes_;
    const std::vector<MovementEdge>& edges_;
    const std::vector<double>& usual_;
    const double square_;
    std::vector<double> mass_;
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
    constexpr int most_steps = 200;
    constexpr double precision = 1e-3;
    Energy energy(nodes, edges, usual, smoothing);
    const std::vector<double> inverse = energy.inverse_diagonal();
    std::vector<double> x(energy.size(), 0.0), residual, direction(energy.size()),
        product_with(energy.size());
    energy.gradient(x, true, residual);
    for (double& r : residual) r = -r;
    std::vector<double> scaled(energy.size());
    const auto precondition = [&] {
        for (std::size_t i = 0; i < scaled.size(); ++i) scaled[i] = inverse[i] * residual[i];
        return product(residual, scaled);
    };
    double square = precondition();
    const double enough = precision * precision * square;
    direction = scaled;
    for (int step = 0; step < most_steps && square > enough; ++step) {
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
    return energy.spread(x, true);
}

}  // namespace anatomesh
