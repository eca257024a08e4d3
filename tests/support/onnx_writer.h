#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/base/files.h"

namespace uniquadric {

/// Writes small ONNX networks, so that tests need no other program: the fields of onnx.proto in protobuf's
/// wire format.
class OnnxWriter {
 public:
  using Shape = std::vector<std::int64_t>;

  /// A dimension of 0 may differ from run to run.
  void input(const std::string& name, const Shape& shape) { graph_ += bytes(11, value_info(name, shape)); }
  void output(const std::string& name, const Shape& shape) { graph_ += bytes(12, value_info(name, shape)); }

  /// A constant.
  void constant(const std::string& name, const Shape& shape, const std::vector<float>& values) {
    std::string tensor, raw(values.size() * sizeof(float), '\0');
    for (const std::int64_t dimension : shape) tensor += number(1, dimension);
    std::memcpy(raw.data(), values.data(), raw.size());
    tensor += number(2, kFloat) + bytes(8, name) + bytes(9, raw);
    graph_ += bytes(5, tensor);
  }

  /// A node; its attributes are lists of integers or one integer.
  void node(const std::string& type, const std::vector<std::string>& inputs, const std::string& output,
            const std::vector<std::pair<std::string, Shape>>& lists = {},
            const std::vector<std::pair<std::string, std::int64_t>>& integers = {}) {
    std::string node;
    for (const auto& name : inputs) node += bytes(1, name);
    node += bytes(2, output) + bytes(3, type + "_" + output) + bytes(4, type);
    for (const auto& [name, values] : lists) {
      std::string attribute = bytes(1, name);
      for (const std::int64_t value : values) attribute += number(8, value);
      node += bytes(5, attribute + number(20, kIntegers));
    }
    for (const auto& [name, value] : integers)
      node += bytes(5, bytes(1, name) + number(3, value) + number(20, kInteger));
    graph_ += bytes(1, node);
  }

  void write(const std::filesystem::path& file) const {
    const std::string opset = bytes(1, "") + number(2, 11);
    write_text(file, number(1, 7) + bytes(7, graph_ + bytes(2, "graph")) + bytes(8, opset));
  }

 private:
  static constexpr int kFloat = 1, kInteger = 2, kIntegers = 7;  // of TensorProto and AttributeProto

  static std::string varint(std::uint64_t value) {
    std::string text;
    for (; value >= 128; value >>= 7) text += static_cast<char>(value | 128);
    return text + static_cast<char>(value);
  }
  static std::string number(int field, std::int64_t value) {
    return varint(std::uint64_t(field) << 3) + varint(static_cast<std::uint64_t>(value));
  }
  static std::string bytes(int field, const std::string& content) {
    return varint(std::uint64_t(field) << 3 | 2) + varint(content.size()) + content;
  }
  static std::string value_info(const std::string& name, const Shape& shape) {
    std::string dimensions;
    for (const std::int64_t size : shape) dimensions += bytes(1, size > 0 ? number(1, size) : bytes(2, "n"));
    return bytes(1, name) + bytes(2, bytes(1, number(1, kFloat) + bytes(2, dimensions)));
  }

  std::string graph_;
};

}  // namespace uniquadric
