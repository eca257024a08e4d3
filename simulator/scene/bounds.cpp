#include "simulator/scene/bounds.h"

#include <fmt/format.h>

#include <cmath>

#include "core/base/config.h"

namespace uniquadric {

double read_between(const ConfigNode& node, const std::string& key, double fallback, double least,
                    double most) {
  const double value = node.get<double>(key, fallback);
  if (value < least || value > most)
    node.at(key).fail(fmt::format("expected {} to {}, found {}", least, most, value));
  return value;
}

double read_at_least_0(const ConfigNode& node, const std::string& key, double fallback) {
  const double value = node.get<double>(key, fallback);
  if (value < 0) node.at(key).fail(fmt::format("cannot be negative, found {}", value));
  return value;
}

double read_at_most(const ConfigNode& node, const std::string& key, double fallback, double most) {
  const double value = read_at_least_0(node, key, fallback);
  if (value > most) node.at(key).fail(fmt::format("expected at most {}, found {}", most, value));
  return value;
}

double read_positive(const ConfigNode& node, const std::string& key, double fallback, double most) {
  const double value = node.positive(key, fallback);
  if (value > most) node.at(key).fail(fmt::format("expected at most {}, found {}", most, value));
  return value;
}

double read_zero_or(const ConfigNode& node, const std::string& key, double fallback, double least,
                    double most) {
  const double value = read_at_most(node, key, fallback, most);
  if (value > 0 && value < least)
    node.at(key).fail(fmt::format("expected 0 or at least {}, found {}", least, value));
  return value;
}

double read_within(const ConfigNode& node, const std::string& key, double fallback, double most) {
  const double value = node.get<double>(key, fallback);
  if (std::abs(value) > most) node.at(key).fail(fmt::format("expected -{0} to {0}, found {1}", most, value));
  return value;
}

Eigen::Vector3d read_within(const ConfigNode& node, const std::string& key, const Eigen::Vector3d& fallback,
                            double most) {
  const auto values = node.get<Eigen::Vector3d>(key, fallback);
  for (const double value : values)
    if (std::abs(value) > most)
      node.at(key).fail(fmt::format("expected -{0} to {0} each, found {1}", most, value));
  return values;
}

}  // namespace uniquadric
