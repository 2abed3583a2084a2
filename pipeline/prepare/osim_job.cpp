#include "prepare/osim_job.hpp"

#include <Eigen/Geometry>
#include <pugixml.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <numeric>
#include <set>

#include "core/document.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "job/job.hpp"
#include "job/ligament_files.hpp"
#include "job/mesh_file.hpp"
#include "job/thesis_files.hpp"
#include "prepare/job_files.hpp"

namespace vrda::prepare {
namespace {

namespace fs = std::filesystem;
using Node = pugi::xml_node;

constexpr double mm_per_metre = 1000.0;
constexpr std::uintmax_t largest_model_bytes = std::uintmax_t{256} << 20U;
// The motion of a joint in contact stays below it; an offset that a model has in its functions (gait2392: the
// length of the femur) does not.
constexpr double largest_motion_m = 0.02;

std::vector<std::string> words_of(Node node)
{
  std::vector<std::string> words;
  const job::NamedText text{"", node.text().get()};
  for (job::TextLines lines(text); lines.next();)
    for (const std::string_view word : lines.words()) words.emplace_back(word);
  return words;
}

/// The components of a model by their absolute paths ("/jointset/knee_r").
class OsimFile {
 public:
  explicit OsimFile(const std::string& file) : file_(file)
  {
    constexpr const char* wanted = "an OpenSim model, version 4 (Version=\"40000\" or later)";
    const std::string text = job::file_bytes(file, {file, "", "", wanted}, largest_model_bytes);
    const pugi::xml_parse_result result = document_.load_buffer(text.data(), text.size());
    if (!result) {
      const auto n_read =
          std::min(text.size(), static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, result.offset)));
      const auto line =
          1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(n_read), '\n');
      throw InputError({file, "", std::string("damaged XML (") + result.description() + ")", wanted,
                        static_cast<int>(line)});
    }
    const Node root = document_.child("OpenSimDocument");
    const std::string version = root.attribute("Version").as_string("none");
    if (!root || !root.attribute("Version") || root.attribute("Version").as_int() < 40000) {
      refuse("OpenSimDocument, Version", root ? version : "no OpenSimDocument",
             std::string(wanted) + "; OpenSim 4 writes an older model in this form");
    }
    model_ = root.child("Model");
    if (!model_) refuse("Model", "nothing", "the model of a joint");
    add(model_, "");
  }

  [[noreturn]] void refuse(const std::string& field, const std::string& found,
                           const std::string& wanted) const
  {
    throw InputError({file_, field, found, wanted});
  }

  Node model() const { return model_; }
  const std::vector<std::pair<std::string, Node>>& components() const { return components_; }

  /// Numbers of an element; `otherwise` where it is missing.
  std::vector<double> numbers(const std::string& path, Node node, const char* element,
                              const std::vector<double>& otherwise, bool is_any_count = false) const
  {
    const Node child = node.child(element);
    if (!child) return otherwise;
    std::vector<double> values;
    for (const std::string& word : words_of(child)) {
      double value = 0.0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
      if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
        refuse(path + ", " + element, quoted_text(word), "a number");
      values.push_back(value);
    }
    if (!is_any_count && values.size() != otherwise.size())
      refuse(path + ", " + element, std::to_string(values.size()) + " numbers",
             std::to_string(otherwise.size()));
    return values;
  }
  Eigen::Vector3d vector(const std::string& path, Node node, const char* element,
                         double otherwise = 0.0) const
  {
    return Eigen::Vector3d(numbers(path, node, element, {otherwise, otherwise, otherwise}).data());
  }
  double number(const std::string& path, Node node, const char* element, double otherwise) const
  {
    return numbers(path, node, element, {otherwise})[0];
  }

  /// The component that a socket or a name refers to.
  std::pair<std::string, Node> component(const std::string& from, const std::string& field,
                                         const std::string& path) const
  {
    const std::string parent = from.substr(0, from.rfind('/'));
    for (const std::string& base : {path.starts_with("/") ? std::string() : from, parent}) {
      std::string at = fs::path(base + "/" + path).lexically_normal().generic_string();
      if (at.ends_with('/')) at.pop_back();
      const auto found = row_.find(at);
      if (found != row_.end()) return components_[found->second];
    }
    // Models of 4.0 betas have names where later ones have paths.
    const std::string name = fs::path(path).filename().string();
    for (const auto& [other, node] : components_)
      if (!name.empty() && fs::path(other).filename().string() == name && is_frame(node))
        return {other, node};
    refuse(from + ", " + field, quoted_text(path), "the path of a frame of the model");
  }

  /// A frame as its body, and its pose in that body in m.
  std::pair<std::string, Pose> frame(std::string from, std::string field, std::string path) const
  {
    Pose X = Pose::Identity();
    constexpr int most_frames = 20;
    for (int k = 0; k < most_frames; ++k) {
      const auto [at, node] = component(from, field, path);
      const std::string type = node.name();
      if (type == "Body" || type == "Ground") return {at, X};
      if (type != "PhysicalOffsetFrame")
        refuse(from + ", " + field, quoted_text(path) + ", a " + type, "a body or a PhysicalOffsetFrame");
      X = pose(at, node, "translation", "orientation") * X;
      from = at;
      field = "socket_parent";
      path = trimmed_text(node.child("socket_parent"));
    }
    refuse(from + ", " + field, "a frame fixed to itself", "a chain of frames that ends at a body");
  }

  /// Rotations about the body-fixed X, Y and Z.
  Pose pose(const std::string& path, Node node, const char* translation, const char* orientation) const
  {
    Pose X = Pose::Identity();
    X.translation() = vector(path, node, translation);
    const Eigen::Vector3d angles_rad = vector(path, node, orientation);
    X.linear() = rotation_x(angles_rad.x()) * rotation_y(angles_rad.y()) * rotation_z(angles_rad.z());
    return X;
  }

  static std::string trimmed_text(Node node)
  {
    const std::string text = node.text().get();
    const std::size_t first = text.find_first_not_of(" \t\r\n"), last = text.find_last_not_of(" \t\r\n");
    return first == std::string::npos ? "" : text.substr(first, last - first + 1);
  }

 private:
  static bool is_frame(Node node)
  {
    const std::string type = node.name();
    return type == "Body" || type == "Ground" || type == "PhysicalOffsetFrame";
  }

  // A set without a name has that of its type in small letters.
  void add(Node node, const std::string& path, int depth = 0)
  {
    constexpr int deepest = 60;
    if (depth > deepest) refuse(path, "deeper nesting", "at most " + std::to_string(deepest) + " levels");
    for (const Node child : node.children()) {
      std::string name = child.attribute("name").as_string(), type = child.name();
      if (name.empty() && type.ends_with("Set")) name = lower_case(type);
      const std::string at = name.empty() ? path : path + "/" + name;
      if (!name.empty() && row_.emplace(at, components_.size()).second) components_.emplace_back(at, child);
      add(child, at, depth + 1);
    }
  }

  std::string file_;
  pugi::xml_document document_;
  Node model_;
  std::vector<std::pair<std::string, Node>> components_;  // in the order of the file
  std::map<std::string, std::size_t> row_;
};

std::string last_name(const std::string& path)
{
  return path.substr(path.rfind('/') + 1);
}

bool contains(const std::string& text, const char* word)
{
  return lower_case(text).find(word) != std::string::npos;
}

/// One of the six axes of a joint: the function of its coordinates along or about it.
struct OsimAxis {
  bool is_rotation = true;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  // of the parent's frame of the joint
  std::vector<std::string> coordinates;
  Node function;
};

struct OsimJoint {
  std::string path, type;
  Node node;
  std::string parent, child;  // paths of bodies
  Pose X_parent_frame, X_child_frame;
  std::vector<OsimAxis> axes;
};

constexpr std::array simple_joints{"CustomJoint", "PinJoint",  "UniversalJoint", "BallJoint",
                                   "GimbalJoint", "FreeJoint", "PlanarJoint"};

/// The rotations of the joints that have no SpatialTransform, as axes of their frames.
std::string simple_axes(const std::string& type)
{
  return type == "PinJoint" || type == "PlanarJoint" ? "Z" : type == "UniversalJoint" ? "XY" : "XYZ";
}

std::vector<OsimAxis> axes_of(const OsimFile& file, const OsimJoint& joint)
{
  std::vector<OsimAxis> axes;
  if (joint.type != "CustomJoint") {
    std::vector<std::string> names;
    for (const Node coordinate : joint.node.child("coordinates").children("Coordinate"))
      names.emplace_back(coordinate.attribute("name").as_string());
    for (const char axis : simple_axes(joint.type)) {
      OsimAxis& one = axes.emplace_back();
      one.axis = Eigen::Vector3d::Unit(axis - 'X');
      if (axes.size() <= names.size()) one.coordinates = {names[axes.size() - 1]};
    }
    return axes;
  }
  for (const Node node : joint.node.child("SpatialTransform").children("TransformAxis")) {
    const std::string path = joint.path + "/" + node.attribute("name").as_string();
    OsimAxis& one = axes.emplace_back();
    one.is_rotation = std::string(node.attribute("name").as_string()).starts_with("rotation");
    one.axis = file.vector(path, node, "axis");
    one.coordinates = words_of(node.child("coordinates"));
    if (one.axis.norm() < 1e-9)
      file.refuse(path + ", axis", core::numbers_text(one.axis, " "), "a direction");
    one.axis.normalize();
    for (const Node child : node.children()) {
      const std::string type = child.name();
      if (type != "coordinates" && type != "axis")
        one.function = type == "function" ? child.first_child() : child;
    }
  }
  return axes;
}

/// Linear between the knots of a spline: it places bodies, it is not the motion.
double value_at(const OsimFile& file, const std::string& path, Node function, double q)
{
  const std::string type = function.name();
  if (type == "Constant") return file.number(path, function, "value", 0.0);
  if (type == "MultiplierFunction") {
    Node inner = function.child("function");
    if (inner) inner = inner.first_child();
    return file.number(path, function, "scale", 1.0) * (inner ? value_at(file, path, inner, q) : 0.0);
  }
  if (type == "LinearFunction" || type == "PolynomialFunction") {
    double value = 0.0;
    for (const double c : file.numbers(path, function, "coefficients", {0.0}, true)) value = value * q + c;
    return value;
  }
  const std::vector<double> x = file.numbers(path, function, "x", {}, true),
                            y = file.numbers(path, function, "y", {}, true);
  if (x.size() != y.size() || x.empty()) return 0.0;
  const std::size_t k = static_cast<std::size_t>(std::upper_bound(x.begin(), x.end(), q) - x.begin());
  if (k == 0 || k == x.size()) return k == 0 ? y.front() : y.back();
  return y[k - 1] + (y[k] - y[k - 1]) * (q - x[k - 1]) / (x[k] - x[k - 1]);
}

/// Where a body is in the frame of the job's files.
struct PlacedBody {
  BodyIndex object;        // that carries it
  bool is_beyond = false;  // further joints are between: its points are fixed to the object, it has no meshes
  Pose X_file_body;        // m
};

/// A body with a joint of its own that ligaments or lines hold.
struct FollowingBody {
  std::string body;
  std::string name;  // of the job
  BodyIndex of = BodyIndex::reference;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  model::Ligaments ligaments;

  bool is_kneecap() const { return contains(name, "patella"); }
};

bool is_follower(BodyIndex object)
{
  return model::row_of(object) >= std::size(all_bodies);
}

class Conversion {
 public:
  /// `dropped`: bodies that cannot follow, with the reason.
  Conversion(const OsimJobOptions& options, const std::map<std::string, std::string>& dropped)
      : options_(options), file_(options.file), dropped_(dropped)
  {
    read_joints();
    find_side();
    find_axes();
    place_bodies();
    add_meshes();
    add_forces();
  }

  std::map<std::string, std::string> impossible_followers() const
  {
    std::map<std::string, std::string> reasons;
    for (std::size_t row = 0; row < followers_.size(); ++row) {
      if (!components_.contains(model::follower_index(row))) reasons[followers_[row].body] = "no mesh";
      if (std::ranges::none_of(followers_[row].ligaments.fibres,
                               [](const model::Fibre& fibre) { return fibre.tension_n == 0.0; }))
        reasons[followers_[row].body] =
            "no ligament holds it, and a coordinate coupled to the joint is not taken over";
    }
    return reasons;
  }

  OsimJob result()
  {
    OsimJob job;
    job.name = kind_ == "other" ? "joint" : kind_;
    job.files = std::move(files_);
    job.text = text(job);
    job.taken = std::move(taken_);
    job.left_out = std::move(left_out_);
    return job;
  }

 private:
  void read_joints()
  {
    std::vector<std::string> names;
    for (const auto& [path, node] : file_.components()) {
      const std::string type = node.name();
      if (!type.ends_with("Joint")) continue;
      OsimJoint joint{path, type, node, {}, {}, Pose::Identity(), Pose::Identity(), {}};
      const auto frame = [&, at = path](const char* socket) {
        const Node named = joint.node.child(socket);
        if (!named) file_.refuse(at + ", " + socket, "nothing", "the path of a frame of the model");
        return file_.frame(at, socket, OsimFile::trimmed_text(named));
      };
      std::tie(joint.parent, joint.X_parent_frame) = frame("socket_parent_frame");
      std::tie(joint.child, joint.X_child_frame) = frame("socket_child_frame");
      joint.axes = axes_of(file_, joint);
      names.push_back(last_name(path));
      for (const Node coordinate : node.child("coordinates").children("Coordinate")) {
        const std::string name = coordinate.attribute("name").as_string();
        default_[name] = file_.number(path + "/" + name, coordinate, "default_value", 0.0);
        range_[name] = file_.numbers(path + "/" + name, coordinate, "range", {-pi, pi});
      }
      joints_.push_back(std::move(joint));
    }
    if (joints_.empty()) file_.refuse("JointSet", "no joints", "at least one joint");
    const auto found = std::find_if(joints_.begin(), joints_.end(), [&](const OsimJoint& joint) {
      return joint.path == options_.joint || last_name(joint.path) == options_.joint;
    });
    if (found == joints_.end())
      throw InputError(
          {options_.file, "--joint", quoted_text(options_.joint), "a joint of the model: " + joined(names)});
    joint_ = static_cast<std::size_t>(found - joints_.begin());
    if (std::find(simple_joints.begin(), simple_joints.end(), found->type) == simple_joints.end())
      file_.refuse(found->path, "a " + found->type,
                   join_alternatives({simple_joints.begin(), simple_joints.end()}));
    kind_ = "other";
    for (const char* kind : {"subtalar", "ankle", "knee", "hip"})
      if (contains(last_name(found->path), kind)) kind_ = kind;
  }

  const OsimJoint& joint() const { return joints_[joint_]; }

  void leave_out(const std::string& what, const std::string& why) { left_out_.push_back(what + ": " + why); }

  // By the endings of names; else by the axis of adduction, which models mirror.
  void find_side()
  {
    if (options_.side) return void(side_ = *options_.side);
    for (const std::string& path : {joint().path, joint().child, joint().parent}) {
      const std::string name = lower_case(last_name(path));
      const bool is_left = name.ends_with("_l") || name.find("left") != std::string::npos;
      if (!is_left && !name.ends_with("_r") && name.find("right") == std::string::npos) continue;
      return void(side_ = is_left ? Side::left : Side::right);
    }
    for (const OsimAxis& axis : joint().axes) {
      if (!axis.is_rotation || std::abs(axis.axis.x()) < 0.9 || joint().type != "CustomJoint") continue;
      return void(side_ = axis.axis.x() < 0.0 ? Side::left : Side::right);
    }
    throw InputError({"--side", "", "nothing, and no name of joint " + last_name(joint().path) + " tells it",
                      "left or right"});
  }

  // The job's axes are those of the joint: the first rotation, then the second one made orthogonal. OpenSim's
  // bodies have X anterior, Y proximal, Z right; each axis becomes the nearest of them.
  void find_axes()
  {
    std::vector<Eigen::Vector3d> rotations;
    for (const OsimAxis& axis : joint().axes)
      if (axis.is_rotation && !axis.coordinates.empty())
        rotations.push_back(joint().X_parent_frame.linear() * axis.axis);
    for (const int fallback : {1, 0, 2}) rotations.push_back(Eigen::Vector3d::Unit(fallback));
    Eigen::Matrix3d& Q = R_body_file_;
    Q.setZero();
    int n = 0;
    std::array<int, 2> at{};
    for (const Eigen::Vector3d& direction : rotations) {
      Eigen::Vector3d axis = direction;
      if (n == 1) axis -= axis.dot(Q.col(at[0])) * Q.col(at[0]);
      if (axis.norm() < 0.1) continue;
      axis.normalize();
      Eigen::Vector3d size = axis.cwiseAbs();
      if (n == 1) size[at[0]] = 0.0;
      const auto k = static_cast<std::size_t>(n);
      size.maxCoeff(&at[k]);
      Q.col(at[k]) = axis[at[k]] < 0.0 ? Eigen::Vector3d(-axis) : axis;
      if (++n == 2) break;
    }
    const int third = 3 - at[0] - at[1];
    Q.col(third) = Q.col((third + 1) % 3).cross(Q.col((third + 2) % 3));
  }

  Eigen::Vector3d translation_m(const OsimJoint& of, bool has_defaults) const
  {
    Eigen::Vector3d t = Eigen::Vector3d::Zero();
    for (const OsimAxis& axis : of.axes)
      if (!axis.is_rotation) t += displacement(of, axis, has_defaults) * axis.axis;
    return t;
  }

  double displacement(const OsimJoint& of, const OsimAxis& axis, bool has_defaults) const
  {
    const auto found = axis.coordinates.empty() ? default_.end() : default_.find(axis.coordinates[0]);
    const double q = has_defaults && found != default_.end() ? found->second : 0.0;
    return axis.function ? value_at(file_, of.path, axis.function, q) : axis.coordinates.empty() ? 0.0 : q;
  }

  Pose default_pose(const OsimJoint& of) const
  {
    Pose X = Pose::Identity();
    X.translation() = translation_m(of, true);
    for (const OsimAxis& axis : of.axes) {
      if (!axis.is_rotation) continue;
      const double angle_rad = displacement(of, axis, true);
      const auto [sin, cos] = sin_cos(angle_rad);
      const Eigen::Vector3d& a = axis.axis;
      Eigen::Matrix3d K;
      K << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
      X.linear() = X.linear() * (Eigen::Matrix3d::Identity() + sin * K + (1.0 - cos) * K * K);
    }
    return X;
  }

  // The joint's frames coincide: its coordinates are zero. Bodies beyond are at the model's default pose.
  void place_bodies()
  {
    Pose X_frames = Pose::Identity();
    if (const Eigen::Vector3d t = translation_m(joint(), false); t.norm() > largest_motion_m) {
      X_frames.translation() = t;
      taken_.push_back("the offset in the functions of joint " + last_name(joint().path) + ", " +
                       rounded_text(mm_per_metre * t.norm(), 4) + " mm at zero, as a part of its frame");
    }
    Pose X_file_parent = Pose::Identity();
    X_file_parent.linear() = R_body_file_.transpose();
    const Pose X_file_centre = X_file_parent * joint().X_parent_frame * X_frames;
    origin_m_ = X_file_centre.translation();
    for (const std::string& name : options_.followers)
      if (std::ranges::none_of(joints_, [&](const OsimJoint& j) { return last_name(j.child) == name; }))
        throw InputError({options_.file, "--followers", quoted_text(name), "a body with a joint of its own"});
    place(joint().parent, {BodyIndex::reference, false, X_file_parent});
    place(joint().child, {BodyIndex::moving, false, X_file_centre * joint().X_child_frame.inverse()});
    for (const auto& [body, why] : dropped_) leave_out(last_name(body), why);
    if (!neighbours_.empty())
      left_out_.push_back("bodies on other joints: " + joined(neighbours_) + "; --followers NAME takes one");
  }

  void place(const std::string& body, const PlacedBody& placed)
  {
    if (!bodies_.emplace(body, placed).second) return;
    for (std::size_t k = 0; k < joints_.size(); ++k) {
      const OsimJoint& next = joints_[k];
      const bool is_parent = next.parent == body;
      if (k == joint_ || (!is_parent && next.child != body)) continue;
      const std::string& other = is_parent ? next.child : next.parent;
      if (other == "/ground") continue;
      if (bodies_.contains(other)) continue;
      const bool follows = !placed.is_beyond && !is_follower(placed.object) && is_named_follower(other);
      Pose X_frames = default_pose(next);
      if (follows && X_frames.translation().norm() < largest_motion_m) X_frames = Pose::Identity();
      const Pose X = next.X_parent_frame * X_frames * next.X_child_frame.inverse();
      PlacedBody further = placed;
      further.X_file_body = placed.X_file_body * (is_parent ? X : X.inverse());
      if (follows) {
        const Pose& X_other_frame = is_parent ? next.X_child_frame : next.X_parent_frame;
        further.object =
            add_follower(other, placed.object, further.X_file_body * X_other_frame.translation());
      } else if (next.type != "WeldJoint" && !contains(last_name(other), "menisc")) {
        if (!placed.is_beyond && !dropped_.contains(other)) neighbours_.push_back(last_name(other));
        further.is_beyond = true;
      }
      place(other, further);
    }
  }

  // The kneecap of a hip or an ankle has its tendon across another joint.
  bool is_named_follower(const std::string& body) const
  {
    const std::string name = last_name(body);
    if (dropped_.contains(body)) return false;
    if (!options_.followers.empty())
      return std::ranges::find(options_.followers, name) != options_.followers.end();
    return (kind_ == "knee" || kind_ == "other") && (contains(name, "patella") || contains(name, "fabella"));
  }

  BodyIndex add_follower(const std::string& body, BodyIndex of, const Eigen::Vector3d& centre_m)
  {
    FollowingBody follower{body, is_plain(last_name(body)) ? last_name(body) : "follower", of, centre_m, {}};
    const bool is_first = std::ranges::none_of(followers_, &FollowingBody::is_kneecap);
    if (follower.is_kneecap()) follower.of = BodyIndex::reference;
    if (follower.is_kneecap() && is_first) follower.name = "patella";
    followers_.push_back(std::move(follower));
    return model::follower_index(followers_.size() - 1);
  }

  struct Component {
    std::string name, material;
    bool has_contact = true;
  };

  std::string mesh_path(const std::string& at, const std::string& element, const std::string& name) const
  {
    const fs::path folder = fs::path(options_.file).parent_path();
    std::vector<fs::path> tried{folder / name, folder / "Geometry" / name};
    for (const std::string& other : options_.folders) tried.push_back(fs::path(other) / name);
    for (const fs::path& path : tried)
      if (fs::is_regular_file(path)) return path.string();
    file_.refuse(at + ", " + element, name.empty() ? "nothing" : "no file " + quoted_text(name),
                 "a mesh beside the model, in its folder Geometry, or in a folder of --geometry");
  }

  void add_meshes()
  {
    std::set<std::string> seen;
    std::map<std::string, std::size_t> other_geometry;
    for (const auto& [path, node] : file_.components()) {
      const std::string type = node.name();
      const bool is_contact = type == "Smith2018ContactMesh" || type == "ContactMesh";
      const bool is_shape = std::string(node.parent().name()) == "attached_geometry";
      if (type != "Mesh" && !is_contact && !is_shape) continue;
      const std::string socket = OsimFile::trimmed_text(node.child("socket_frame"));
      const auto [body, X_body_frame] = file_.frame(path, "socket_frame", socket.empty() ? ".." : socket);
      const auto placed = bodies_.find(body);
      if (placed == bodies_.end() || placed->second.is_beyond) continue;
      if (type != "Mesh" && !is_contact) {
        leave_out("geometry " + path, "a " + type + ", no mesh");
        continue;
      }
      const std::string element = type == "ContactMesh" ? "filename" : "mesh_file";
      const std::string file = mesh_path(path, element, OsimFile::trimmed_text(node.child(element.c_str())));
      if (!seen.insert(body + "\n" + fs::weakly_canonical(file).string()).second) continue;
      Pose X_frame_mesh = Pose::Identity();
      if (is_contact) X_frame_mesh = file_.pose(path, node, "location", "orientation");
      add_mesh(path, file, node, placed->second.object,
               placed->second.X_file_body * X_body_frame * X_frame_mesh);
    }
    for (const BodyIndex object : all_bodies)
      if (!components_.contains(object))
        file_.refuse(object == BodyIndex::reference ? joint().parent : joint().child, "no meshes",
                     "at least one mesh of the body");
  }

  void add_mesh(const std::string& path, const std::string& file, Node node, BodyIndex object,
                const Pose& X_file_mesh)
  {
    const Eigen::Vector3d scale = file_.vector(path, node, "scale_factors", 1.0);
    if (scale.prod() == 0.0)
      file_.refuse(path + ", scale_factors", core::numbers_text(scale, " "), "factors other than 0");
    job::RawMesh mesh =
        job::read_mesh(file, job::file_bytes(file, {file, "", "", "a mesh file"}, job::largest_mesh_bytes));
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
      const Eigen::Vector3d p = mesh.vertices.row(v).transpose().cwiseProduct(scale);
      mesh.vertices.row(v) = (X_file_mesh * p).transpose();
      vertices_m_[object].push_back(mesh.vertices.row(v).transpose());
    }
    mesh.normals.resize(0, 3);
    if (scale.prod() < 0.0) {  // mirrored
      auto first = mesh.corner.begin();
      for (const std::int32_t size : mesh.size) {
        std::reverse(first, first + size);
        first += size;
      }
    }
    const std::string own = last_name(path);
    const std::string stem = is_plain(own) ? own : "mesh";
    std::string name = stem;
    for (int k = 2; !names_.insert(name).second; ++k) name = stem + "_" + std::to_string(k);
    const auto has = [&](const char* word) {
      return contains(name, word) || contains(fs::path(file).stem().string(), word);
    };
    Component component{name, has("menisc") ? "meniscus" : has("cart") ? "cartilage" : "bone"};
    component.has_contact =
        options_.drawn.empty()
            ? component.material != "meniscus" && (!has("fibula") || is_follower(object))
            : std::find(options_.drawn.begin(), options_.drawn.end(), own) == options_.drawn.end();
    files_.emplace_back(name + ".stl", job::mesh_bytes(name + ".stl", mesh));
    components_[object].push_back(component);
    taken_.push_back("mesh " + path + (component.has_contact ? "" : ", drawn only"));
  }

  static bool is_plain(const std::string& name) { return job::is_component_name(name); }

  /// A point of a path in the frame of the files, mm, and the body that carries it.
  struct PathPoint {
    BodyIndex object;
    bool is_beyond;
    Eigen::Vector3d p_mm;
  };

  static auto objects_of(Node path, const std::string& set)
  {
    return path.find_node([&](Node n) { return n.name() == set; }).child("objects").children();
  }

  // Empty if a point is on no body of the model's tree, or moves on its body.
  std::vector<PathPoint> path_of(const std::string& force, Node node, std::string& problem) const
  {
    std::vector<PathPoint> points;
    for (const Node point : objects_of(node, "PathPointSet")) {
      const std::string at = force + "/" + point.attribute("name").as_string();
      const auto [body, X_body_frame] =
          file_.frame(at, "socket_parent_frame", OsimFile::trimmed_text(point.child("socket_parent_frame")));
      const auto placed = bodies_.find(body);
      if (placed == bodies_.end()) {
        problem = "a point on " + last_name(body);
        return {};
      }
      if (std::string(point.name()) == "MovingPathPoint") {
        problem = "point " + last_name(at) + " moves on its body";
        continue;
      }
      points.push_back(
          {placed->second.object, placed->second.is_beyond,
           mm_per_metre * (placed->second.X_file_body * X_body_frame * file_.vector(at, point, "location"))});
    }
    return points;
  }

  void add_forces()
  {
    std::map<std::string, int> others;
    for (const auto& [path, node] : file_.components()) {
      const std::string type = node.name();
      if (type == "Blankevoort1991Ligament" || type == "Ligament") {
        add_ligament(path, node);
      } else if (type.ends_with("Muscle") || type == "PathActuator") {
        add_muscle(path, node);
      } else if (const std::string set = node.parent().parent().name(); set == "ForceSet") {
        ++others[type];
      }
    }
    for (const auto& [type, n] : others) {
      const bool is_contact = type.starts_with("Smith2018") || type.starts_with("ElasticFoundation") ||
                              type.starts_with("HuntCrossley");
      left_out_.push_back(std::to_string(n) + " " + type + (is_contact ? ": the job has exact contact" : ""));
    }
    if (n_muscles_ > 0)
      left_out_.push_back(std::to_string(n_muscles_) +
                          " muscles across the joint: --muscles SHARE takes them as lines");
    if (!elsewhere_.empty())
      left_out_.push_back(std::to_string(elsewhere_.size()) +
                          " ligaments and muscles of other joints: " + joined(elsewhere_));
    if (ligaments_.fibres.empty())
      left_out_.push_back("ligaments: the model has none across the joint; contact alone holds it" +
                          std::string(kind_ == "knee"
                                          ? "; vrda prepare, with the bones written here, takes a "
                                            "template's"
                                          : ""));
  }

  void add_ligament(const std::string& path, Node node)
  {
    std::string problem;
    const std::vector<PathPoint> points = path_of(path, node, problem);
    std::set<BodyIndex> objects;
    for (const PathPoint& p : points) objects.insert(p.object);
    if (objects.size() < 2 && (objects.empty() || !is_follower(*objects.begin())))
      return elsewhere_.push_back(last_name(path));
    const std::string what = "ligament " + path;
    if (points.size() != 2 || !problem.empty())
      return leave_out(
          what, problem.empty() ? std::to_string(points.size()) + " points, a fibre has two" : problem);
    if (points[0].is_beyond || points[1].is_beyond) return leave_out(what, "an end on a further body");
    if (objects.size() < 2) return leave_out(what, "both ends on one body");
    model::Fibre fibre;
    fibre.name = last_name(path);
    fibre.bundle = job::default_bundle(fibre.name);
    const bool has_curve = std::string(node.name()) == "Ligament";
    fibre.stiffness_n =
        has_curve ? fitted_stiffness_n(path, node) : file_.number(path, node, "linear_stiffness", 0.0);
    const char* length = has_curve ? "resting_length" : "slack_length";
    fibre.slack_length_mm = mm_per_metre * file_.number(path, node, length, 0.0);
    if (!(fibre.stiffness_n > 0.0)) return leave_out(what, "no stiffness");
    if (!(fibre.slack_length_mm > 0.0)) return leave_out(what, "no " + std::string(length));
    add_transition(file_.number(path, node, "transition_strain", default_transition), fibre.name);
    add_fibre(points[0], points[1], fibre, path, node);
  }

  static constexpr double default_transition = 0.06;

  void add_transition(double strain, const std::string& fibre)
  {
    if (!transition_strain_) transition_strain_ = strain;
    if (strain != *transition_strain_)
      leave_out("ligament " + fibre, "transition strain " + rounded_text(strain) +
                                         ", the job has one for all, " + rounded_text(*transition_strain_));
  }

  // Least squares of the job's law to the force of the curve, up to the strain at which ligaments fail.
  double fitted_stiffness_n(const std::string& path, Node node)
  {
    Node curve = node.child("force_length_curve");
    if (curve) curve = curve.first_child();
    if (!curve) curve = node.find_child_by_attribute("name", "force_length_curve");
    if (!curve) return 0.0;
    constexpr double failure_strain = 0.2;
    constexpr int n_samples = 100;
    double sum_ff = 0.0, sum_fl = 0.0;
    for (int k = 1; k <= n_samples; ++k) {
      const double strain = failure_strain * k / n_samples;
      const double law = model::tension_of(strain, 1.0, default_transition).force_n;
      sum_ff += law * law;
      sum_fl +=
          law * file_.number(path, node, "pcsa_force", 1.0) * value_at(file_, path, curve, 1.0 + strain);
    }
    taken_.push_back("ligament " + path + ": stiffness fitted to its curve up to a strain of 0.2");
    return sum_fl / sum_ff;
  }

  // Reference before moving, a follower after the objects before it.
  void add_fibre(PathPoint from, PathPoint to, model::Fibre fibre, const std::string& path, Node node)
  {
    if (to.object < from.object) std::swap(from, to);
    fibre.from = from.object;
    fibre.to = to.object;
    fibre.reference_mm = from.p_mm;
    fibre.moving_mm = to.p_mm;
    model::Ligaments& all =
        is_follower(to.object) ? followers_[model::follower_row(to.object)].ligaments : ligaments_;
    const auto is_same = [&](const model::Fibre& other) { return other.name == fibre.name; };
    if (std::any_of(all.fibres.begin(), all.fibres.end(), is_same) || !is_field(fibre.name))
      return leave_out("ligament " + path,
                       is_field(fibre.name) ? "its name a second time" : "a comma in its name");
    fibre.wrap = wrap_of(all, fibre, path, node);
    all.fibres.push_back(fibre);
  }

  static bool is_field(const std::string& name)
  {
    return !name.empty() && name.find_first_of(",;\t\"#") == std::string::npos;
  }

  // The row of the first wrap that the job can have; the others are left out.
  int wrap_of(model::Ligaments& all, const model::Fibre& fibre, const std::string& path, Node force)
  {
    int row = -1;
    for (const Node use : objects_of(force, "PathWrapSet")) {
      const std::string name = OsimFile::trimmed_text(use.child("wrap_object"));
      const std::string what = "wrap " + name + " of " + path;
      const auto found = std::ranges::find(all.wraps, name, &model::Wrap::name);
      if (row >= 0)
        leave_out(what, "a fibre has one wrap");
      else if (found == all.wraps.end())
        row = read_wrap(all, fibre, name, what);
      else if (is_end(fibre, found->body))
        row = static_cast<int>(found - all.wraps.begin());
      else
        leave_out(what, "on a third body");
    }
    return row;
  }

  static bool is_end(const model::Fibre& fibre, BodyIndex object)
  {
    return object == fibre.from || object == fibre.to;
  }

  int read_wrap(model::Ligaments& all, const model::Fibre& fibre, const std::string& name,
                const std::string& what)
  {
    const auto found =
        std::find_if(file_.components().begin(), file_.components().end(), [&](const auto& one) {
          return last_name(one.first) == name && std::string(one.second.name()).starts_with("Wrap") &&
                 bodies_.contains(owner_of(one.first));
        });
    if (found == file_.components().end()) return leave_out(what, "not on a body of the model"), -1;
    const auto& [path, node] = *found;
    const std::string type = node.name();
    const PlacedBody& body = bodies_.at(owner_of(path));
    if (type != "WrapCylinder" && type != "WrapEllipsoid" && type != "WrapSphere")
      return leave_out(what, "a " + type), -1;
    if (body.is_beyond) return leave_out(what, "on a further body"), -1;
    if (!is_end(fibre, body.object)) return leave_out(what, "on a third body"), -1;
    if (lower_case(OsimFile::trimmed_text(node.child("active"))) == "false")
      return leave_out(what, "not active"), -1;
    const std::string quadrant = OsimFile::trimmed_text(node.child("quadrant"));
    if (!quadrant.empty() && quadrant != "all")
      leave_out(what, "quadrant " + quadrant + ": fibres take the shorter path on either side");
    model::Wrap wrap;
    wrap.name = name;
    wrap.shape = type == "WrapCylinder" ? model::WrapShape::cylinder : model::WrapShape::ellipsoid;
    const double radius_mm = mm_per_metre * file_.number(path, node, "radius", 0.0);
    wrap.radii_mm = type == "WrapEllipsoid"
                        ? Eigen::Vector3d(mm_per_metre * file_.vector(path, node, "dimensions"))
                        : Eigen::Vector3d::Constant(radius_mm);
    if (type == "WrapCylinder")
      wrap.radii_mm.z() = 0.5 * mm_per_metre * file_.number(path, node, "length", 1.0);
    const double ratio = wrap.radii_mm.maxCoeff() / wrap.radii_mm.minCoeff();
    constexpr double largest_ratio = 5.0;  // of schemas/ligaments.md
    if (!(wrap.radii_mm.minCoeff() > 0.0)) return leave_out(what, "no size"), -1;
    if (type == "WrapEllipsoid" && ratio > largest_ratio)
      return leave_out(what, "half-axes with a ratio above 5"), -1;
    wrap.body = body.object;
    const auto [owner, X_body_frame] = file_.frame(path, "owner", "../..");
    wrap.X_body_wrap =
        body.X_file_body * X_body_frame * file_.pose(path, node, "translation", "xyz_body_rotation");
    wrap.X_body_wrap.translation() *= mm_per_metre;
    all.wraps.push_back(wrap);
    return static_cast<int>(all.wraps.size()) - 1;
  }

  // The body of a wrap, BODY/wrapobjectset/WRAP.
  std::string owner_of(const std::string& wrap) const { return file_.frame(wrap, "owner", "../..").first; }

  void add_muscle(const std::string& path, Node node)
  {
    std::string problem;
    std::vector<PathPoint> points = path_of(path, node, problem);
    const auto is_reference = [](const PathPoint& p) { return p.object == BodyIndex::reference; };
    const auto n_reference = std::ranges::count_if(points, is_reference);
    const auto follower = std::ranges::find_if(
        points, [](const PathPoint& p) { return is_follower(p.object) && !p.is_beyond; });
    const bool has_follower = follower != points.end(),
               is_actuator = std::string(node.name()) == "PathActuator";
    const bool crosses = n_reference > 0 && n_reference < static_cast<std::ptrdiff_t>(points.size());
    if (points.size() < 2 || (!crosses && !has_follower)) return elsewhere_.push_back(last_name(path));
    if (!options_.muscle_share && !has_follower) return void(++n_muscles_);
    const std::string what = "muscle " + path;
    const double largest_n = file_.number(path, node, is_actuator ? "optimal_force" : "max_isometric_force",
                                          is_actuator ? 1.0 : 1000.0);
    const double tension_n = largest_n * (is_actuator ? 1.0 : options_.muscle_share.value_or(1.0));
    if (!problem.empty()) leave_out(what, problem + (points.empty() ? "" : ": the line has the others"));
    if (has_follower) return add_follower_line(points, follower, tension_n, path, node);
    if (node.find_node([](Node n) { return std::string(n.name()) == "PathWrap"; }))
      leave_out(what, "its wraps: the line has none");
    if (!is_reference(points.front())) std::reverse(points.begin(), points.end());
    const auto first = std::find_if_not(points.begin(), points.end(), is_reference);
    if (std::any_of(first, points.end(), is_reference))
      return leave_out(what, "it goes back to the first body");
    const auto list = [&](auto from, auto to) {
      std::string text;
      for (; from != to; ++from)
        text +=
            (text.empty() ? "[" : ", [") + core::numbers_text(from->p_mm - mm_per_metre * origin_m_) + "]";
      return text;
    };
    lines_ += "\n[[push.line]]\nname = " + quoted_text(last_name(path)) +
              "\ntension_n = " + shortest_decimal(tension_n) + "\nreference_mm = [" +
              list(points.begin(), first) + "]\nmoving_mm = [" + list(first, points.end()) + "]\n";
    taken_.push_back(what + " as a line of " + rounded_text(tension_n) + " N");
  }

  // Without --muscles: a patella that nothing pulls up slips off the femur.
  static constexpr double quadriceps_n = 30.0;

  void add_follower_line(const std::vector<PathPoint>& points, std::vector<PathPoint>::const_iterator at,
                         double tension_n, const std::string& path, Node node)
  {
    const FollowingBody& follower = followers_[model::follower_row(at->object)];
    if (at == points.begin() || (at - 1)->object == at->object)
      return leave_out("muscle " + path, "it begins on the " + follower.name);
    if (at + 1 != points.end()) leave_out("muscle " + path, "its part beyond the " + follower.name);
    model::Fibre line;
    line.name = last_name(path);
    line.bundle = follower.is_kneecap() ? "quadriceps" : job::default_bundle(line.name);
    line.tension_n = tension_n;
    add_fibre(*(at - 1), *at, line, path, node);
    taken_.push_back("muscle " + path + " as a line of the " + follower.name + ", " +
                     (options_.muscle_share ? rounded_text(tension_n) + " N"
                                            : "its share of " + rounded_text(quadriceps_n) + " N"));
  }

  std::string components_text(const std::string& body, BodyIndex object) const
  {
    std::string text;
    for (const Component& component : components_.at(object))
      text += "\n[[" + body + ".component]]\nname = " + quoted_text(component.name) +
              "\nfile = " + quoted_text(component.name + ".stl") + "\nmaterial = \"" + component.material +
              "\"\n" + (component.has_contact ? "" : "contact = false                       # drawn only\n");
    return text;
  }

  /// The model's coordinates by the job's names, with the sign of [opensim].
  std::map<std::string, std::string> coordinate_names() const
  {
    const double side = side_ == Side::left ? -1.0 : 1.0;
    const std::array<double, 3> positive{side, side,
                                         -1.0};  // varus, internal rotation, flexion (schemas/clinical.md)
    constexpr std::array rotations{"varus", "internal", "flexion"}, translations{"tx", "ty", "tz"};
    std::map<std::string, std::string> names;
    for (const OsimAxis& axis : joint().axes) {
      const std::string function = axis.function.name();
      if (axis.coordinates.size() != 1 || (axis.function && function != "LinearFunction")) continue;
      const Eigen::Vector3d in_file = R_body_file_.transpose() * joint().X_parent_frame.linear() * axis.axis;
      Eigen::Index k = 0;
      in_file.cwiseAbs().maxCoeff(&k);
      const auto row = static_cast<std::size_t>(k);
      const double slope = axis.function ? value_at(file_, joint().path, axis.function, 1.0) -
                                               value_at(file_, joint().path, axis.function, 0.0)
                                         : 1.0;
      const double sign = slope * in_file[k] * (axis.is_rotation ? positive[row] : 1.0);
      names.emplace(axis.is_rotation ? rotations[row] : translations[row],
                    (sign < 0.0 ? "-" : "") + axis.coordinates[0]);
    }
    return names;
  }

  /// The model's range of a rotation within `from_deg` to `to_deg`, as far as it has one.
  std::string range_text(const std::map<std::string, std::string>& names, const char* coordinate,
                         double from_deg, double to_deg, double step_deg) const
  {
    if (const auto named = names.find(coordinate); named != names.end()) {
      const bool is_negative = named->second[0] == '-';
      const auto range = range_.find(named->second.substr(is_negative ? 1 : 0));
      const auto degrees = [](double rad) { return std::round(1e6 * deg_from_rad(rad)) / 1e6; };
      if (range != range_.end()) {
        const double low_deg =
            std::max(from_deg, degrees(is_negative ? -range->second[1] : range->second[0]));
        const double high_deg = std::min(to_deg, degrees(is_negative ? -range->second[0] : range->second[1]));
        if (high_deg - low_deg >= step_deg) std::tie(from_deg, to_deg) = std::pair(low_deg, high_deg);
      }
    }
    return "{ from = " + shortest_decimal(from_deg) + ", to = " + shortest_decimal(to_deg) +
           ", step = " + shortest_decimal(step_deg) + " }\n";
  }

  // As the jobs of this kind of joint in jobs/.
  std::string motion_text(const std::map<std::string, std::string>& names) const
  {
    const auto range = [&](const char* coordinate, double from_deg, double to_deg, double step_deg) {
      return std::string(coordinate) + " = " + range_text(names, coordinate, from_deg, to_deg, step_deg);
    };
    if (kind_ == "knee")
      return "\n[grid]                                # degrees\n" + range("flexion", 0, 90, 1) +
             "varus = \"free\"\n";
    const std::string head = "\n[coordinates]                         # degrees\n";
    if (kind_ == "hip") return head + range("flexion", -100, 20, 5) + "varus = 0\ninternal = 0\n";
    if (kind_ == "ankle")
      return head + range("flexion", -20, 40, 5) + "varus = \"free\"\ninternal = \"free\"\n";
    if (kind_ == "subtalar") return head + range("varus", -10, 10, 1) + "flexion = 0\ninternal = 0\n";
    const char* driven = names.contains("flexion") ? "flexion"
                         : names.contains("varus") ? "varus"
                                                   : "internal";
    std::string text = head + range(driven, -30, 30, 5);
    for (const char* other : {"flexion", "varus", "internal"})
      if (std::string(other) != driven) text += std::string(other) + " = 0\n";
    return text;
  }

  std::string text(OsimJob& job)
  {
    const std::map<std::string, std::string> names = coordinate_names();
    const std::string model = file_.model().attribute("name").as_string(),
                      file = fs::path(options_.file).filename().string();
    std::string text =
        "# Written by vrda convert osim from " + quoted_text(file) + ", joint " +
        quoted_text(last_name(joint().path)) +
        ". Axes and origin are those of\n# the joint; the pose of the meshes is that of its zero "
        "coordinates.\n"
        "title = " +
        quoted_text(is_utf8(model) ? model.substr(0, 100) + ", " + last_name(joint().path) : file) +
        "\njoint = \"" + kind_ + "\"\nside = \"" + side_name(side_) + "\"\n";
    if (!names.empty())
      text += "\n[opensim]                             # its coordinates, for vrda export\n";
    for (const auto& [coordinate, name] : names) text += coordinate + " = " + quoted_text(name) + "\n";
    text += "\n[frame]\nunit = \"m\"\nanterior = \"+X\"\nproximal = \"+Y\"\nright = \"+Z\"\norigin = [" +
            core::numbers_text(origin_m_) +
            "]\n\n[reference]\nname = " + quoted_text(last_name(joint().parent)) + "\n" +
            components_text("reference", BodyIndex::reference) +
            "\n[moving]\nname = " + quoted_text(last_name(joint().child)) + "\n" +
            components_text("moving", BodyIndex::moving) +
            "\n[push]\nforce_n = 20                          # along delta\n" + lines_;
    if (!ligaments_.fibres.empty()) {
      text += "\n[ligaments]\nfibres = \"ligaments.csv\"\n";
      job.files.emplace_back(
          "ligaments.csv",
          ligament_table(ligaments_, "from the OpenSim model " + escape_control_characters(file)));
      if (!ligaments_.wraps.empty()) {
        text += "wraps = \"wraps.json\"\n";
        job.files.emplace_back("wraps.json", wraps_text(ligaments_));
      }
      text += transition_text();
      taken_.push_back(std::to_string(ligaments_.fibres.size()) + " fibres, " +
                       std::to_string(ligaments_.wraps.size()) + " wraps");
    }
    std::vector<std::string> names_of_followers;
    for (const FollowingBody& follower : followers_) {
      names_of_followers.push_back(follower.name);
      text += follower_text(job, follower, names_of_followers);
    }
    return text + motion_text(names) + "\n[solver]\nmethod = \"equilibrium\"\n\n[smooth]\ndegrees = [" +
           (kind_ == "knee" ? "6" : "") + "]\n";
  }

  std::string transition_text() const
  {
    return transition_strain_ && *transition_strain_ != default_transition
               ? "transition_strain = " + shortest_decimal(*transition_strain_) + "\n"
               : "";
  }

  // The stiffest bundle from the moving object: its width resists turning, which lines do not.
  static std::string tendon_text(const model::Ligaments& ligaments)
  {
    std::map<std::string, double> stiffness_n;
    for (const model::Fibre& fibre : ligaments.fibres)
      if (fibre.from == BodyIndex::moving) stiffness_n[fibre.bundle] += fibre.stiffness_n;
    const auto stiffest = std::ranges::max_element(stiffness_n, {}, [](const auto& of) { return of.second; });
    if (stiffest == stiffness_n.end() || !(stiffest->second > 0.0)) return "";
    return "\n[[follower.direction]]                # not of the model: its width keeps its "
           "direction\nbundle = " +
           quoted_text(stiffest->first) + "\nstiffness_nmm_per_rad = 3000\n";
  }

  // A kneecap meets what it touches posteriorly; another body where that is nearest.
  std::string contact_text(const FollowingBody& follower, BodyIndex object) const
  {
    if (follower.is_kneecap()) return "";
    const std::vector<Eigen::Vector3d>& own = vertices_m_.at(object);
    const Eigen::Vector3d centre_m =
        std::accumulate(own.begin(), own.end(), Eigen::Vector3d(Eigen::Vector3d::Zero())) /
        static_cast<double>(own.size());
    const Eigen::Vector3d nearest_m =
        *std::ranges::min_element(vertices_m_.at(follower.of), {},
                                  [&](const Eigen::Vector3d& p_m) { return (p_m - centre_m).squaredNorm(); });
    std::vector<std::string> delta;
    for (const double x : (nearest_m - centre_m).normalized()) delta.push_back(rounded_text(x, 3));
    return "of = \"" + std::string(name_of(follower.of)) + "\"\npush.delta = [" + joined(delta) +
           "]        # to the nearest point of it\n";
  }

  std::string follower_text(OsimJob& job, const FollowingBody& follower,
                            const std::vector<std::string>& names)
  {
    const BodyIndex object = model::follower_index(names.size() - 1);
    const model::Ligaments& ligaments = follower.ligaments;
    double tension_n = 0.0;
    for (const model::Fibre& fibre : ligaments.fibres) tension_n += fibre.tension_n;
    const std::string fibres = follower.name + "_fibres.csv", wraps = follower.name + "_wraps.json";
    std::string text = "\n[[follower]]                          # " +
                       std::string(follower.is_kneecap() ? "the kneecap: " : "") +
                       "schemas/followers.md\nname = " + quoted_text(follower.name) + "\ncentre_mm = [" +
                       core::numbers_text(mm_per_metre * follower.centre_m) +
                       "]\nfibres = " + quoted_text(fibres) + "\n";
    if (!ligaments.wraps.empty()) {
      text += "wraps = " + quoted_text(wraps) + "\n";
      job.files.emplace_back(wraps, wraps_text(ligaments, names));
    }
    text += contact_text(follower, object) + transition_text();
    if (tension_n > 0.0)
      text += options_.muscle_share
                  ? "tension_n = " + shortest_decimal(tension_n) + "\n"
                  : "tension_n = " + shortest_decimal(quadriceps_n) +
                        "                        # of its lines together; --muscles: the model's\n";
    if (std::ranges::any_of(components_.at(follower.of), [](const Component& c) { return !c.has_contact; }))
      text += "touches_visual = true                 # also what is drawn only\n";
    if (follower.is_kneecap()) text += tendon_text(ligaments);
    job.files.emplace_back(fibres, follower_table(ligaments, names, std::nullopt, "from an OpenSim model"));
    taken_.push_back(last_name(follower.body) + " as a follower with " +
                     std::to_string(ligaments.fibres.size()) + " fibres and lines");
    return text + components_text("follower", object);
  }

  const OsimJobOptions& options_;
  OsimFile file_;
  const std::map<std::string, std::string>& dropped_;
  std::vector<OsimJoint> joints_;
  std::size_t joint_ = 0;
  std::map<std::string, double> default_;  // of coordinates
  std::map<std::string, std::vector<double>> range_;
  std::string kind_;
  Side side_ = Side::right;
  Eigen::Matrix3d R_body_file_ = Eigen::Matrix3d::Identity();  // of the joint's parent
  Eigen::Vector3d origin_m_ = Eigen::Vector3d::Zero();
  std::map<std::string, PlacedBody> bodies_;
  std::vector<FollowingBody> followers_;
  std::vector<std::string> neighbours_, elsewhere_;
  std::set<std::string> names_;
  std::map<BodyIndex, std::vector<Component>> components_;
  std::map<BodyIndex, std::vector<Eigen::Vector3d>> vertices_m_;
  model::Ligaments ligaments_;
  std::optional<double> transition_strain_;
  std::string lines_;
  int n_muscles_ = 0;
  std::vector<std::pair<std::string, std::string>> files_;
  std::vector<std::string> taken_, left_out_;
};

}  // namespace

OsimJob osim_job(const OsimJobOptions& options)
{
  std::map<std::string, std::string> dropped;
  while (true) {
    Conversion conversion(options, dropped);
    std::map<std::string, std::string> more = conversion.impossible_followers();
    if (more.empty()) return conversion.result();
    dropped.merge(more);
  }
}

}  // namespace vrda::prepare
