#include "estimator/plausibility/axis_turns.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>

namespace uniquadric {

std::vector<AxisTurn> axis_turns() {
  std::vector<AxisTurn> turns;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      AxisTurn& turn = turns.emplace_back();
      turn.matrix.setZero();
      for (int row = 0; row < 3; ++row) {
        const bool is_negative = (signs >> row) & 1;
        turn.matrix(row, order[row]) = is_negative ? -1 : 1;
        turn.name += std::string(row > 0 ? " " : "") + (is_negative ? "-" : "") + "xyz"[order[row]];
      }
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return turns;
}

std::vector<AxisTurn> proper_axis_turns() {
  std::vector<AxisTurn> turns = axis_turns();
  std::erase_if(turns, [](const AxisTurn& turn) { return turn.matrix.determinant() < 0; });
  return turns;
}

}  // namespace uniquadric
