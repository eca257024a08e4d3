#include "core/base/hungarian.h"

#include <limits>

namespace uniquadric {
namespace {

// Kuhn-Munkres on costs with rows <= columns, by successive shortest augmenting paths. Row and column 0 are
// placeholders, as in the usual statement of the algorithm.
std::vector<int> minimum_assignment(const Eigen::MatrixXd& costs) {
  const int rows = static_cast<int>(costs.rows()), columns = static_cast<int>(costs.cols());
  std::vector<double> row_potential(rows + 1), column_potential(columns + 1);
  std::vector<int> row_of(columns + 1), previous(columns + 1);
  for (int row = 1; row <= rows; ++row) {
    std::vector<double> slack(columns + 1, std::numeric_limits<double>::infinity());
    std::vector<bool> visited(columns + 1);
    row_of[0] = row;
    int column = 0;
    while (row_of[column] != 0) {
      visited[column] = true;
      const int from = row_of[column];
      int next = 0;
      double step = std::numeric_limits<double>::infinity();
      for (int j = 1; j <= columns; ++j) {
        if (visited[j]) continue;
        const double reduced = costs(from - 1, j - 1) - row_potential[from] - column_potential[j];
        if (reduced < slack[j]) {
          slack[j] = reduced;
          previous[j] = column;
        }
        if (slack[j] < step) {
          step = slack[j];
          next = j;
        }
      }
      for (int j = 0; j <= columns; ++j) {
        if (visited[j]) {
          row_potential[row_of[j]] += step;
          column_potential[j] -= step;
        } else {
          slack[j] -= step;
        }
      }
      column = next;
    }
    for (; column != 0; column = previous[column]) row_of[column] = row_of[previous[column]];
  }
  std::vector<int> column_of(rows, -1);
  for (int j = 1; j <= columns; ++j)
    if (row_of[j] != 0) column_of[row_of[j] - 1] = j - 1;
  return column_of;
}

}  // namespace

std::vector<int> maximum_assignment(const Eigen::MatrixXd& weights) {
  if (weights.rows() <= weights.cols()) return minimum_assignment(-weights);
  const std::vector<int> row_of = minimum_assignment(-weights.transpose());
  std::vector<int> column_of(static_cast<std::size_t>(weights.rows()), -1);
  for (std::size_t column = 0; column < row_of.size(); ++column)
    column_of[static_cast<std::size_t>(row_of[column])] = static_cast<int>(column);
  return column_of;
}

}  // namespace uniquadric
