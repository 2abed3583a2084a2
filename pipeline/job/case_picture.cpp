#include "job/case_picture.hpp"

#include <algorithm>
#include <cmath>

#include "core/canvas.hpp"
#include "core/document.hpp"
#include "core/text.hpp"
#include "job/component_loader.hpp"
#include "model/frames.hpp"

namespace vrda::job {
namespace {

constexpr int panel_width_px = 800, height_px = 1000;
constexpr double panel_top_px = 120.0, panel_bottom_px = 880.0, margin_px = 70.0;
constexpr double text_px = 24.0, title_px = 32.0, axis_px = 130.0;
// About the rotation centre of a knee: the attachments of its ligaments, not the shafts.
constexpr double shown_above_mm = 80.0, shown_below_mm = 110.0;

const Colour black(0.1F, 0.1F, 0.1F), grey(0.45F, 0.45F, 0.45F);
const Colour reference_colour(0.93F, 0.80F, 0.56F), moving_colour(0.55F, 0.74F, 0.93F);
const Colour follower_colour(0.75F, 0.85F, 0.60F);
const Colour inside_colour(0.55F, 0.16F, 0.20F);
const Colour fibre_colour(0.0F, 0.47F, 0.16F), line_colour(0.75F, 0.32F, 0.0F),
    push_colour(0.76F, 0.0F, 0.62F);
const Colour smoothed_colour(0.55F, 0.10F, 0.60F);
constexpr double full_colour_mm = 1.0;  // of vertices moved by smoothing; the legend says so
const std::array<Colour, 3> axis_colours{Colour(0.82F, 0.10F, 0.08F), Colour(0.10F, 0.20F, 0.85F),
                                         Colour(0.80F, 0.42F, 0.0F)};

// A view from direction `towards`, proximal up.
struct View {
  Eigen::Vector3d rightward, towards;
  std::string title, left_word, right_word;
};

View front_view(const job::Case& job_case)
{
  const bool is_knee = job_case.joint == "knee", is_right = job_case.frame.side == Side::right;
  View view{-Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX(), "from the front", "right", "left"};
  if (is_knee) view.left_word += is_right ? " (lateral)" : " (medial)";
  if (is_knee) view.right_word += is_right ? " (medial)" : " (lateral)";
  return view;
}

View side_view(const job::Case& job_case)
{
  const bool is_knee = job_case.joint == "knee", is_right = job_case.frame.side == Side::right;
  if (is_knee && !is_right) {
    return {-Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ(), "from the lateral side, the left",
            "anterior", "posterior"};
  }
  return {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ(),
          is_knee ? "from the lateral side, the right" : "from the right", "posterior", "anterior"};
}

View opposite(const View& view, const std::string& title)
{
  return {-view.rightward, -view.towards, title, view.right_word, view.left_word};
}

std::vector<View> views_of(const job::Case& job_case, const PictureNotes& notes)
{
  std::vector<View> views{front_view(job_case), side_view(job_case)};
  if (!notes.has_four_views) return views;
  const bool is_left_knee = job_case.joint == "knee" && job_case.frame.side == Side::left;
  const std::string other = is_left_knee ? "the right" : "the left";
  views.push_back(opposite(views[0], "from behind"));
  views.push_back(
      opposite(views[1], job_case.joint == "knee" ? "from the medial side, " + other : "from " + other));
  return views;
}

// Projection of canonical coordinates to the pixels of a view.
struct Projection {
  View view;
  Eigen::Vector3d middle_mm;
  Eigen::Vector2d middle_px;
  double px_per_mm;

  Eigen::Vector3d operator()(const Eigen::Vector3d& p_mm) const
  {
    const Eigen::Vector3d arm_mm = p_mm - middle_mm;
    return {middle_px.x() + px_per_mm * arm_mm.dot(view.rightward), middle_px.y() - px_per_mm * arm_mm.y(),
            px_per_mm * arm_mm.dot(view.towards)};
  }
};

struct Arrow {
  Eigen::Vector3d from_mm, to_mm;
};

void include(Box& box, const Eigen::Vector3d& p_mm)
{
  box.min_mm = box.min_mm.cwiseMin(p_mm);
  box.max_mm = box.max_mm.cwiseMax(p_mm);
}

Box box_of_bones(const job::Case& job_case)
{
  Box box = box_of(job_case.reference);
  const auto add = [&](const Body& body) {
    const Box own = box_of(body);
    box = {box.min_mm.cwiseMin(own.min_mm), box.max_mm.cwiseMax(own.max_mm)};
  };
  add(job_case.moving);
  for (const Follower& follower : job_case.followers) add(follower.body);
  return box;
}

// The part of a box near the rotation centre.
Box near_joint(Box box, const Eigen::Vector3d& centre_mm)
{
  box.min_mm.y() = std::max(box.min_mm.y(), centre_mm.y() - shown_below_mm);
  box.max_mm.y() = std::min(box.max_mm.y(), centre_mm.y() + shown_above_mm);
  return box;
}

// Ends behind the moving object, along the push, or at the end of what is shown of it.
Arrow push_arrow(const job::Case& job_case, const Box& shown, double length_mm)
{
  const Eigen::Vector3d& delta = job_case.push_at_meshes.delta;
  const Eigen::Vector3d at_mm = job_case.frame.rotation_centre_mm + job_case.push_point_mm;
  Box moving = box_of(job_case.moving);
  moving.min_mm = moving.min_mm.cwiseMax(shown.min_mm);
  moving.max_mm = moving.max_mm.cwiseMin(shown.max_mm);
  const Eigen::Vector3d foot_mm =
      (delta.array() > 0.0).select(moving.min_mm, moving.max_mm);  // the rearmost corner
  const double back_mm = (foot_mm - at_mm).dot(delta) - 0.1 * length_mm;
  const Eigen::Vector3d to_mm = at_mm + back_mm * delta;
  return {to_mm - length_mm * delta, to_mm};
}

// How much smoothing moved the corners of a triangle, from 0 to 1.
float tint_of(const Mesh& mesh, Eigen::Index t, const MovedVertices& moved)
{
  if (moved.empty()) return 0.0F;
  double sum_mm = 0.0;
  for (const Eigen::Vector3d& corner : corners(mesh, t)) {
    const Eigen::Vector3f p = corner.cast<float>();
    const auto found = moved.find({p.x(), p.y(), p.z()});
    if (found != moved.end()) sum_mm += std::min(found->second, full_colour_mm);
  }
  return static_cast<float>(sum_mm / (3.0 * full_colour_mm));
}

void draw_part(Canvas& canvas, const Projection& projected, const Part& part, const Colour& colour,
               const MovedVertices& moved)
{
  for (Eigen::Index t = 0; t < part.mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(part.mesh, t);
    const Eigen::Vector3d normal = face_normal(part.mesh, t);
    const double facing = normal.dot(projected.view.towards);
    const double lit = 0.45 + 0.45 * std::abs(facing) + 0.1 * std::max(0.0, normal.y());
    const Colour outside = colour + tint_of(part.mesh, t, moved) * (smoothed_colour - colour);
    const Colour shaded = static_cast<float>(lit) * (facing >= 0.0 ? outside : inside_colour);
    canvas.draw_triangle({projected(a), projected(b), projected(c)}, shaded.cwiseMin(1.0F));
  }
}

void draw_arrow(Canvas& canvas, const Eigen::Vector3d& from_px, const Eigen::Vector3d& to_px, double line_px,
                const Colour& colour)
{
  canvas.draw_line(from_px, to_px, line_px, colour);
  const Eigen::Vector2d along = (to_px - from_px).head<2>();
  constexpr double head_px = 16.0, shortest_px = 4.0;
  if (along.norm() < shortest_px) return canvas.draw_disc(to_px.head<2>(), line_px, colour);
  const Eigen::Vector2d back = -head_px * along.normalized(), across(0.5 * back.y(), -0.5 * back.x());
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector2d end = back + side * across;
    canvas.draw_line(to_px, to_px + Eigen::Vector3d(end.x(), end.y(), 0.0), line_px, colour);
  }
}

// At a distance beyond the arrow's end.
void draw_label(Canvas& canvas, const Eigen::Vector3d& from_px, const Eigen::Vector3d& to_px,
                const std::string& text, const Colour& colour)
{
  const Eigen::Vector2d along = (to_px - from_px).head<2>();
  constexpr double shortest_px = 15.0, gap_px = 12.0;
  if (along.norm() < shortest_px) return;
  const Eigen::Vector2d direction = along.normalized();
  const TextAlign align = direction.x() > 0.5    ? TextAlign::left
                          : direction.x() < -0.5 ? TextAlign::right
                                                 : TextAlign::centre;
  const Eigen::Vector2d at =
      to_px.head<2>() + gap_px * direction + Eigen::Vector2d(0.0, 8.0 * (1.0 + direction.y()));
  for (const double x : {-1.5, 1.5}) {  // a white outline for contrast over bones
    for (const double y : {-1.5, 1.5})
      canvas.draw_text(at + Eigen::Vector2d(x, y), text_px, text, align, Colour::Ones());
  }
  canvas.draw_text(at, text_px, text, align, colour);
}

void draw_axes(Canvas& canvas, const Projection& projected, const job::Case& job_case,
               const PictureNotes& notes)
{
  const Eigen::Vector3d& centre_mm = job_case.frame.rotation_centre_mm;
  const Eigen::Vector3d from = projected(centre_mm);
  for (std::size_t k = 0; k < axis_names.size(); ++k) {
    const Eigen::Vector3d to = projected(centre_mm + axis_px / projected.px_per_mm *
                                                         Eigen::Vector3d::Unit(static_cast<Eigen::Index>(k)));
    draw_arrow(canvas, from, to, 5.0, axis_colours.at(k));
    const std::string& file_axis = notes.file_axes.at(k);
    draw_label(canvas, from, to, axis_names.at(k) + (file_axis.empty() ? "" : " (file " + file_axis + ")"),
               axis_colours.at(k));
  }
  canvas.draw_disc(from.head<2>(), 10.0, black);
  canvas.draw_disc(from.head<2>(), 6.0, Colour::Ones());
}

std::string push_text(const job::Case& job_case)
{
  const job::Push& push = job_case.push.front();
  if (job_case.method != "equilibrium") return "push";
  return "push, " + short_decimal(push.force_n.dot(push.delta), 1) + " N";
}

// 1, 2 or 5 times a power of ten, at most a quarter of the panel.
void draw_scale(Canvas& canvas, const Projection& projected)
{
  constexpr double longest_px = 200.0;
  double length_mm = 1e-3;
  for (double decade_mm = 1e-3; decade_mm < 1e6; decade_mm *= 10.0) {
    for (const double step : {1.0, 2.0, 5.0}) {
      if (step * decade_mm * projected.px_per_mm <= longest_px) length_mm = step * decade_mm;
    }
  }
  const Eigen::Vector3d from(projected.middle_px.x() - 370.0, panel_bottom_px + 22.0, 0.0);
  const Eigen::Vector3d to = from + Eigen::Vector3d(length_mm * projected.px_per_mm, 0.0, 0.0);
  canvas.draw_line(from, to, 5.0, black);
  canvas.draw_text(to.head<2>() + Eigen::Vector2d(12.0, 8.0), text_px, short_decimal(length_mm, 3) + " mm",
                   TextAlign::left, black);
}

std::vector<Eigen::Vector3d> canonical_points_mm(const job::Case& job_case, const job::LinePath& line)
{
  std::vector<Eigen::Vector3d> points = line.reference_mm;
  points.insert(points.end(), line.moving_mm.begin(), line.moving_mm.end());
  for (Eigen::Vector3d& p_mm : points) p_mm += job_case.frame.rotation_centre_mm;
  return points;
}

void draw_path(Canvas& canvas, const Projection& projected, const job::Case& job_case,
               const job::LinePath& line)
{
  const std::vector<Eigen::Vector3d> points = canonical_points_mm(job_case, line);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector3d at = projected(points[k]);
    if (k > 0) canvas.draw_line(projected(points[k - 1]), at, 5.0, line_colour);
    canvas.draw_disc(at.head<2>(), 6.0, line_colour);
  }
}

// Those of constant tension as the lines of the joint.
void draw_fibres(Canvas& canvas, const Projection& projected, const model::Ligaments& ligaments)
{
  for (const model::Fibre& fibre : ligaments.fibres) {
    const Colour& colour = fibre.tension_n > 0.0 ? line_colour : fibre_colour;
    const Eigen::Vector3d a = projected(fibre.reference_mm), b = projected(fibre.moving_mm);
    canvas.draw_line(a, b, 3.0, colour);
    canvas.draw_disc(a.head<2>(), 4.0, colour);
    canvas.draw_disc(b.head<2>(), 4.0, colour);
  }
}

void draw_view(Canvas& canvas, const Projection& projected, const job::Case& job_case, const Arrow& push,
               const PictureNotes& notes)
{
  const Colour pale = 0.5F * Colour::Ones();
  draw_part(canvas, projected, job_case.reference.contact, reference_colour, notes.moved[0]);
  draw_part(canvas, projected, job_case.moving.contact, moving_colour, notes.moved[1]);
  draw_part(canvas, projected, job_case.reference.visual, 0.5F * reference_colour + pale, notes.moved[0]);
  draw_part(canvas, projected, job_case.moving.visual, 0.5F * moving_colour + pale, notes.moved[1]);
  draw_fibres(canvas, projected, job_case.ligaments);
  for (const Follower& follower : job_case.followers) {
    draw_part(canvas, projected, follower.body.contact, follower_colour, {});
    draw_part(canvas, projected, follower.body.visual, 0.5F * follower_colour + pale, {});
    draw_fibres(canvas, projected, follower.ligaments);
  }
  for (const job::LinePath& line : job_case.lines) draw_path(canvas, projected, job_case, line);
  draw_arrow(canvas, projected(push.from_mm), projected(push.to_mm), 8.0, push_colour);
  // Below the arrow: beside one that leans, the text would leave the panel.
  const Eigen::Vector3d tail = projected(push.from_mm);
  draw_label(canvas, tail - Eigen::Vector3d::UnitY() * axis_px, tail, push_text(job_case), push_colour);
  draw_axes(canvas, projected, job_case, notes);
  draw_scale(canvas, projected);
  const double x = projected.middle_px.x();
  canvas.draw_text({x, 78.0}, text_px, projected.view.title, TextAlign::centre, black);
  canvas.draw_text({x - 385.0, 108.0}, text_px, projected.view.left_word, TextAlign::left, grey);
  canvas.draw_text({x + 385.0, 108.0}, text_px, projected.view.right_word, TextAlign::right, grey);
}

void draw_legend(Canvas& canvas, const job::Case& job_case, const PictureNotes& notes)
{
  struct Entry {
    std::string text;
    Colour colour;
  };
  std::vector<Entry> entries{{job_case.reference.name + " (reference)", reference_colour},
                             {job_case.moving.name + " (moving)", moving_colour},
                             {"not in contact: paler", Colour(0.85F, 0.85F, 0.85F)},
                             {"back face", inside_colour},
                             {std::to_string(job_case.ligaments.fibres.size()) + " fibres", fibre_colour}};
  for (const Follower& follower : job_case.followers)
    entries.insert(entries.begin() + 2, {follower.name + " (follows)", follower_colour});
  if (!job_case.lines.empty())
    entries.push_back({"lines of tension: " + std::to_string(job_case.lines.size()), line_colour});
  if (!notes.moved[0].empty() || !notes.moved[1].empty())
    entries.push_back({"moved by smoothing: 1 mm or more", smoothed_colour});
  double x = 30.0;
  for (const Entry& entry : entries) {
    canvas.draw_line({x, 938.0, 0.0}, {x + 24.0, 938.0, 0.0}, 16.0, entry.colour);
    canvas.draw_text({x + 40.0, 946.0}, text_px, entry.text, TextAlign::left, black);
    x += 70.0 + 12.5 * static_cast<double>(entry.text.size());
  }
  const Eigen::Vector3d shift_mm = (100.0 * job_case.initial.translation_mm).array().round() / 100.0 + 0.0;
  canvas.draw_text({30.0, 984.0}, text_px,
                   notes.refusal.empty()
                       ? "Ring: rotation centre. Pose of the mesh files; initial translation [" +
                             core::numbers_text(shift_mm) +
                             "] mm. Warnings: " + std::to_string(notes.n_warnings) + "." + notes.smoothing
                       : notes.refusal,
                   TextAlign::left, black);
}

double px_per_mm_of(const Box& box)
{
  const Eigen::Vector3d size_mm = box.max_mm - box.min_mm;
  const double across_mm = std::max({size_mm.x(), size_mm.z(), 1e-9});
  return std::min((panel_width_px - 2.0 * margin_px) / across_mm,
                  (panel_bottom_px - panel_top_px - margin_px) / std::max(size_mm.y(), 1e-9));
}

// What the views show: bones, push, fibres, lines, and the axes, whose length is one in pixels.
Box box_of_view(const job::Case& job_case, Box box, const Arrow& push)
{
  const Eigen::Vector3d& centre_mm = job_case.frame.rotation_centre_mm;
  for (const Eigen::Vector3d& p_mm : {centre_mm, push.from_mm, push.to_mm}) include(box, p_mm);
  for (const model::Fibre& fibre : job_case.ligaments.fibres) {
    include(box, fibre.reference_mm);
    include(box, fibre.moving_mm);
  }
  for (const job::LinePath& line : job_case.lines) {
    for (const Eigen::Vector3d& p_mm : canonical_points_mm(job_case, line)) include(box, p_mm);
  }
  include(box, centre_mm + Eigen::Vector3d::Constant(axis_px / px_per_mm_of(box)));
  return box;
}

}  // namespace

std::string case_picture(const job::Case& job_case, const PictureNotes& notes)
{
  Box box = box_of_bones(job_case);
  if (notes.has_four_views) box = near_joint(box, job_case.frame.rotation_centre_mm);
  const Arrow push = push_arrow(job_case, box, 0.15 * (box.max_mm - box.min_mm).maxCoeff());
  box = box_of_view(job_case, box, push);
  const double scale = px_per_mm_of(box);
  const std::vector<View> views = views_of(job_case, notes);
  const int width_px = panel_width_px * static_cast<int>(views.size());
  Canvas canvas(width_px, height_px);
  const double y_px = 0.5 * (panel_top_px + panel_bottom_px);
  const Eigen::Vector3d middle_mm = 0.5 * (box.min_mm + box.max_mm);
  double left_px = 0.0;
  for (const View& view : views) {
    canvas.set_clip({left_px, panel_top_px}, {left_px + panel_width_px, panel_bottom_px + 30.0});
    draw_view(canvas, {view, middle_mm, {left_px + 0.5 * panel_width_px, y_px}, scale}, job_case, push,
              notes);
    left_px += panel_width_px;
  }
  canvas.set_clip({0.0, 0.0}, {static_cast<double>(width_px), static_cast<double>(height_px)});
  for (double x_px = panel_width_px; x_px < width_px; x_px += panel_width_px)
    canvas.draw_line({x_px, 60.0, 0.0}, {x_px, 905.0, 0.0}, 1.5, grey);
  const std::string side = side_name(job_case.frame.side);
  const std::string joint =
      job_case.joint == "knee" ? side + " knee" : "joint \"" + job_case.joint + "\", " + side + " side";
  canvas.draw_text({0.5 * width_px, 42.0}, title_px,
                   job_case.title + ": " + joint + (notes.refusal.empty() ? "" : ", REFUSED"),
                   TextAlign::centre, black);
  draw_legend(canvas, job_case, notes);
  return canvas.png();
}

}  // namespace vrda::job
