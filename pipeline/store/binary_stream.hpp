/// A motion model as a stream of its values in memory layout, for the pipe from the process that reads HDF5
/// to its parent, which is the same program: no byte order, no version. A stream that ends early throws
/// InputError.
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/text.hpp"
#include "model/step_record.hpp"
#include "store/motion_model.hpp"
#include "store/registry.hpp"
#include "store/solved_cells.hpp"

namespace vrda::store {

/// pass() appends a value; as a registry visitor it appends every value of the registry.
class BinaryWriter : public RegistryVisitor {
 public:
  /// Until reserve_counted(), bytes are only counted.
  void count() { is_counting_ = true; }
  void reserve_counted()
  {
    is_counting_ = false;
    bytes_.reserve(n_counted_);
  }
  std::string take() { return std::move(bytes_); }

  template <typename Value>
  void write_value(const Value& value)
  {
    if constexpr (std::is_same_v<Value, std::string>) {
      write_value(static_cast<std::uint32_t>(value.size()));
      append(value.data(), value.size());
    } else if constexpr (std::is_same_v<Value, Eigen::Vector3d>) {
      append(value.data(), 3 * sizeof(double));
    } else {
      static_assert(std::is_arithmetic_v<Value>);
      append(&value, sizeof value);
    }
  }

  bool has(const std::string&, bool is_there) override
  {
    write_value(is_there);
    return is_there;
  }
  void dimension(const std::string& path, const DimensionSize& count) override
  {
    RegistryVisitor::dimension(path, count);
    if (count.kind != DimensionSize::Kind::fixed) write_value(count.n);
  }

 private:
  void visit_attribute(const std::string&, const std::string&, Attribute value, const Unit&) override
  {
    std::visit([&](const auto* one) { write_value(*one); }, value);
  }
  void visit_list(const std::string&, List list) override
  {
    std::visit(
        [&](const auto* elements) {
          write_value(static_cast<std::uint32_t>(elements->size()));
          for (const auto& element : *elements) write_value(group_name(element));
        },
        list);
  }
  void visit_dataset(const Dataset&, Member member) override
  {
    with_values(member, [&]<typename Scalar>(std::span<Scalar> values) {
      if constexpr (std::is_same_v<Scalar, std::string>) {
        for (const std::string& text : values) write_value(text);
      } else {
        append(values.data(), values.size_bytes());
      }
    });
  }

  void append(const void* data, std::size_t size)
  {
    if (is_counting_) {
      n_counted_ += size;
    } else if (size > 0) {
      bytes_.append(static_cast<const char*>(data), size);
    }
  }

  std::string bytes_;
  std::size_t n_counted_ = 0;
  bool is_counting_ = false;
};

/// Inverse of BinaryWriter. Throws InputError naming `file` where the bytes end or are invalid.
class BinaryReader : public RegistryVisitor {
 public:
  BinaryReader(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  std::size_t left() const { return bytes_.size(); }
  bool may_change() const override { return true; }

  template <typename Value>
  void read_value(Value& value)
  {
    if constexpr (std::is_same_v<Value, std::string>) {
      std::uint32_t size = 0;
      read_value(size);
      require(size);
      value.assign(bytes_.substr(0, size));
      bytes_.remove_prefix(size);
    } else if constexpr (std::is_same_v<Value, Eigen::Vector3d>) {
      take(value.data(), 3 * sizeof(double));
    } else if constexpr (std::is_same_v<Value, bool>) {
      std::int8_t code = 0;
      take(&code, 1);
      value = code != 0;
    } else {
      static_assert(std::is_arithmetic_v<Value>);
      take(&value, sizeof value);
    }
  }

  bool has(const std::string&, bool) override
  {
    bool is_there = false;
    read_value(is_there);
    return is_there;
  }
  void dimension(const std::string& path, const DimensionSize& count) override
  {
    std::int64_t n = count.n;
    if (count.kind != DimensionSize::Kind::fixed) read_value(n);
    const bool is_axis = count.kind == DimensionSize::Kind::axis;
    if (n < (is_axis ? 1 : 0) || n > std::numeric_limits<std::int32_t>::max()) refuse(path);
    RegistryVisitor::dimension(path, DimensionSize::fixed(n));
  }

  /// Throws unless at least `size` bytes remain.
  void require(std::uint64_t size) const
  {
    if (size <= bytes_.size()) return;
    throw InputError({file_, "", std::to_string(bytes_.size()) + " bytes of serialized values",
                      std::to_string(size) + " bytes"});
  }

 private:
  void visit_attribute(const std::string&, const std::string&, Attribute value, const Unit&) override
  {
    std::visit([&](auto* one) { read_value(*one); }, value);
  }
  void visit_list(const std::string& group, List list) override
  {
    /// Limit of sets and audits; the file's reader accepts 10000 objects.
    constexpr std::uint32_t most_elements = 1000;
    std::uint32_t n = 0;
    read_value(n);
    if (n > most_elements) refuse(group);
    std::visit(
        [&](auto* elements) {
          elements->resize(n);
          for (auto& element : *elements) {
            std::string name;
            read_value(name);
            if (!set_group_name(element, name)) refuse(group);
          }
        },
        list);
  }
  void visit_dataset(const Dataset& dataset, Member member) override
  {
    const std::vector<std::int64_t> shape = shape_of(dataset);
    std::uint64_t bytes = bytes_of(kind_of(member));
    for (const std::int64_t size : shape) {
      if (__builtin_mul_overflow(bytes, static_cast<std::uint64_t>(size), &bytes)) refuse(dataset.path);
    }
    require(bytes);
    std::visit([&](auto* all) { resize(*all, shape); }, member);
    with_values(member, [&]<typename Scalar>(std::span<Scalar> values) {
      if constexpr (std::is_same_v<Scalar, std::string>) {
        for (std::string& text : values) read_value(text);
      } else {
        take(values.data(), values.size_bytes());
      }
    });
  }

  [[noreturn]] void refuse(const std::string& where) const
  {
    throw InputError({file_, where, "invalid serialized bytes", "serialized values"});
  }

  void take(void* data, std::size_t size)
  {
    require(size);
    if (size > 0) std::memcpy(data, bytes_.data(), size);
    bytes_.remove_prefix(size);
  }

  std::string_view bytes_;
  const std::string& file_;
};

// Compressed rows of contacts and contact forces, as in the motion model.

/// Compressed rows, cell by cell, of the contacts that `contacts_of(record)` returns (a span of ContactRecord
/// or ContactForce), in W; `measure` and `measures` are the member specific to that type.
template <typename Rows, typename Contact, typename ContactsOf>
Rows compressed_rows(const MotionModel& model, const std::vector<StepRecord>& cells,
                     const ContactsOf& contacts_of, double Contact::*measure,
                     std::vector<double> Rows::*measures)
{
  std::size_t n = 0;
  for (const StepRecord& r : cells) n += contacts_of(r).size();
  Rows rows;
  rows.point_world_mm.resize(static_cast<Eigen::Index>(n), 3);
  rows.normal_world.resize(static_cast<Eigen::Index>(n), 3);
  rows.row_start.push_back(0);
  Eigen::Index row = 0;
  for (const StepRecord& r : cells) {
    const SolverFrame frame = solver_frame(model, r.key.flexion);
    for (const Contact& contact : contacts_of(r)) {
      rows.point_world_mm.row(row) = world_from_solver(frame, contact.point_solver_mm).transpose();
      rows.normal_world.row(row) = world_from_solver(frame, contact.normal_solver).transpose();
      (rows.*measures).push_back(contact.*measure);
      rows.triangle_reference.push_back(contact.triangle_reference);
      rows.triangle_moving.push_back(contact.triangle_moving);
      rows.compartment.push_back(contact.compartment);
      ++row;
    }
    rows.row_start.push_back(row);
  }
  return rows;
}

}  // namespace vrda::store
