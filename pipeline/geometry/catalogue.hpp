/// Registry of the generated shapes for shapes.hpp: name, parameters with units and limits, and builder of
/// each. Meshes and fibres are in mm, canonical axes; values were checked against the limits before a builder
/// is called.
#pragma once

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "geometry/shapes.hpp"

namespace vrda::geometry {

/// The complete, validated parameters of a request.
class ShapeValues {
 public:
  double number(const std::string& name) const { return numbers_.at(name); }
  int integer(const std::string& name) const { return static_cast<int>(std::lround(numbers_.at(name))); }
  const std::string& word(const std::string& name) const { return words_.at(name); }
  void set(const std::string& name, double value) { numbers_[name] = value; }
  void set(const std::string& name, const std::string& value) { words_[name] = value; }

 private:
  std::map<std::string, double> numbers_;
  std::map<std::string, std::string> words_;
};

struct CatalogueEntry {
  std::string name;
  std::string summary;
  std::vector<ShapeParameter> parameters;
  Shape (*build)(const ShapeValues&) = nullptr;
  std::vector<ShapeFibre> (*fibres)(const ShapeValues&) = nullptr;  ///< null: no ligaments
  std::string fibre_sources;                                        ///< comment lines of the fibre table
};

/// In the order of the help text.
const std::vector<CatalogueEntry>& shape_catalogue();

}  // namespace vrda::geometry
