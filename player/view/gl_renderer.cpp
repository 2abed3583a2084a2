// Draws scenes by OpenGL into a frame buffer: background, opaque and translucent surfaces, overlay,
// distortion.
#include "view/gl_context.hpp"

#include <GL/glcorearb.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "view/gl_occlusion.hpp"
#include "view/gl_picture.hpp"
#include "view/gl_surfaces.hpp"
#include "view/gl_table.hpp"
#include "view/gl_translucency.hpp"
#include "view/shaders.hpp"

namespace vrda::view {
namespace {

bool is_black(const view::Background& background)
{
  return background.top.isZero(0.0F) && background.bottom.isZero(0.0F);
}

class GlRenderer final : public Renderer {
 public:
  GlRenderer(std::unique_ptr<GlContext> context, const RenderOptions& options);
  ~GlRenderer() override;

  void load(const view::Scene& scene) override;
  void load(const OverlayFont& font) override;
  void load(const view::Warp& warp) override;
  void resize(int width, int height) override;
  void set_samples(int samples) override;
  int width() const override { return options_.width; }
  int height() const override { return options_.height; }
  const Image& draw(const view::Scene& scene, std::span<const Shot> shots, const Overlay* overlay) override;
  void present(const view::Scene& scene, std::span<const Shot> shots, const Overlay* overlay) override;
  bool present_again(const Overlay* overlay) override;

 private:
  void check_size(const RenderOptions& options) const;
  void open_targets();
  void close_targets();
  void size_picture(int width, int height);
  void draw_background(const view::Background& background);
  void draw_occlusion(const view::Scene& scene, const view::Camera& camera, const PixelBox& box);
  void draw_shot(const view::Scene& scene, std::size_t row, const Shot& shot);
  void draw_frame(const view::Scene& scene, std::span<const Shot> shots, const Overlay* overlay,
                  bool is_for_screen);
  void blit(unsigned from, unsigned to, int w, int h);
  void draw_overlay(const Overlay* overlay, unsigned frame);
  void show_on_screen();
  void read_pixels();

  int possible_samples(int samples) const { return std::min(samples, most_samples_); }
  bool is_multisampled() const { return options_.samples > 1; }
  TargetPlan plan() const
  {
    return {options_.width, options_.height, is_multisampled() ? options_.samples : 0};
  }
  /// The complete frame: drawn directly, or resolved from samples.
  const Target& finished() const { return is_multisampled() ? set_.resolved : set_.drawn; }
  /// The output after warping, and its size.
  const Target& shown() const { return warper_ ? warper_->warped() : finished(); }
  int shown_width() const { return warper_ ? warper_->width() : options_.width; }
  int shown_height() const { return warper_ ? warper_->height() : options_.height; }
  void size_image();
  bool finds_srgb_screen() const;

  std::unique_ptr<GlContext> context_;
  GlTable gl_;
  RenderOptions options_;
  int most_samples_ = 1;
  unsigned background_program_ = 0, empty_array_ = 0;
  int top_ = -1, bottom_ = -1;
  // Created after the context is current and destroyed while it still is.
  std::optional<SurfacePainter> surfaces_;
  std::optional<OverlayPainter> overlays_;
  std::optional<WarpPainter> warper_;
  std::optional<FragmentLists> lists_;
  /// Frame buffers of one number of samples, and what draws to them.
  struct TargetSet {
    int samples = 0;  ///< 0: not open
    Target drawn, resolved;
    std::unique_ptr<LayerPeeler> peeler;
    std::unique_ptr<OcclusionPainter> occlusion;  ///< from its first use on
  };
  void close(TargetSet& set);
  TargetSet set_;
  TargetSet other_set_;  ///< kept, so that set_samples() between two numbers takes no time
  /// By shot: what is drawn, and what changed since the last frame. Outside the former `set_.drawn` is black
  /// if `is_sparse_`, so that software rendering clears, resolves and warps a fraction of the pixels.
  std::vector<PixelBox> used_, changed_;
  bool is_sparse_ = false;
  /// The frame of the window can be drawn to, as its values are encoded like those of warped().
  bool has_srgb_screen_ = false;
  bool is_on_screen_ = false;     ///< the last frame was drawn to the window itself
  bool is_picture_kept_ = false;  ///< `set_.drawn` has the last frame's surfaces, without its overlay
  std::vector<std::uint8_t> upside_down_;
  Image image_;
};

GlRenderer::GlRenderer(std::unique_ptr<GlContext> context, const RenderOptions& options)
    : context_(std::move(context)), options_(options)
{
  context_->make_current();
  gl_ = load_gl_table(*context_);
  check_size(options);
  GLint most_samples = 0, most_depth_samples = 0;
  gl_.GetIntegerv(GL_MAX_SAMPLES, &most_samples);
  gl_.GetIntegerv(GL_MAX_DEPTH_TEXTURE_SAMPLES, &most_depth_samples);
  most_samples_ = std::max(1, std::min(most_samples, most_depth_samples));
  options_.samples = possible_samples(options.samples);
  const char* const first = "#version 330 core\n";
  background_program_ = linked_program(gl_, first, background_vertex_shader, background_fragment_shader);
  top_ = gl_.GetUniformLocation(background_program_, "top");
  bottom_ = gl_.GetUniformLocation(background_program_, "bottom");
  gl_.GenVertexArrays(1, &empty_array_);
  gl_.ClearColor(0.0F, 0.0F, 0.0F, 1.0F);  // between the shots
  surfaces_.emplace(gl_, SurfaceOptions{options_.coarseness_px, options_.has_deferred_levels});
  overlays_.emplace(gl_);
  has_srgb_screen_ = finds_srgb_screen();
  open_targets();
  check(gl_.GetError() == GL_NO_ERROR, "the renderer opens without an OpenGL error");
}

GlRenderer::~GlRenderer()
{
  context_->make_current();
  close_targets();
  warper_.reset();
  lists_.reset();
  overlays_.reset();
  surfaces_.reset();
  gl_.DeleteVertexArrays(1, &empty_array_);
  gl_.DeleteProgram(background_program_);
}

void GlRenderer::check_size(const RenderOptions& options) const
{
  GLint most = 0;
  gl_.GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &most);
  if (std::min(options.width, options.height) < 1 || std::max(options.width, options.height) > most) {
    throw InputError({"image", "size", std::to_string(options.width) + "x" + std::to_string(options.height),
                      "1 to " + std::to_string(most) + " pixels each way"});
  }
  check(options.samples >= 1, "there is at least one sample per pixel");
}

void GlRenderer::open_targets()
{
  const int w = options_.width, h = options_.height;
  set_.drawn = create_target(gl_, plan());
  set_.samples = options_.samples;
  set_.peeler = std::make_unique<LayerPeeler>(gl_, plan(), set_.drawn);
  if (!lists_ && !is_multisampled() && FragmentLists::is_supported(gl_)) lists_.emplace(gl_);
  if (lists_) lists_->resize(w, h);
  if (is_multisampled()) set_.resolved = create_target(gl_, {w, h, 0, false});
  size_image();
}

void GlRenderer::size_image()
{
  image_.width = shown_width();
  image_.height = shown_height();
  image_.rgba.resize(static_cast<std::size_t>(image_.width) * static_cast<std::size_t>(image_.height) * 4);
  upside_down_.resize(image_.rgba.size());
}

void GlRenderer::close(TargetSet& set)
{
  set.peeler.reset();
  set.occlusion.reset();
  destroy_target(gl_, set.drawn);
  destroy_target(gl_, set.resolved);
  set.samples = 0;
}

void GlRenderer::close_targets()
{
  close(set_);
  close(other_set_);
  is_sparse_ = is_picture_kept_ = false;
}

void GlRenderer::resize(int width, int height)
{
  if (width == options_.width && height == options_.height) return;
  context_->make_current();
  if (warper_) return;
  size_picture(width, height);
}

void GlRenderer::set_samples(int samples)
{
  if (possible_samples(samples) == options_.samples) return;
  context_->make_current();
  std::swap(set_, other_set_);
  is_sparse_ = is_picture_kept_ = false;
  options_.samples = possible_samples(samples);
  if (set_.samples != options_.samples) {
    close(set_);
    open_targets();
  }
  check(gl_.GetError() == GL_NO_ERROR, "the samples change without an OpenGL error");
}

void GlRenderer::size_picture(int width, int height)
{
  RenderOptions resized = options_;
  resized.width = width;
  resized.height = height;
  check_size(resized);
  close_targets();
  options_ = resized;
  open_targets();
  check(gl_.GetError() == GL_NO_ERROR, "the renderer is resized without an OpenGL error");
}

void GlRenderer::load(const view::Scene& scene)
{
  context_->make_current();
  is_picture_kept_ = false;
  surfaces_->load(scene);
  check(gl_.GetError() == GL_NO_ERROR, "meshes load without an OpenGL error");
}

void GlRenderer::load(const OverlayFont& font)
{
  context_->make_current();
  overlays_->load(font);
  check(gl_.GetError() == GL_NO_ERROR, "a font loads without an OpenGL error");
}

void GlRenderer::load(const view::Warp& warp)
{
  context_->make_current();
  RenderOptions shown = options_;
  shown.width = warp.width;
  shown.height = warp.height;
  check_size(shown);
  warper_.reset();
  is_sparse_ = false;
  if (warp.source_width > 0) size_picture(warp.source_width, warp.source_height);
  warper_.emplace(gl_, warp, options_.width, options_.height);
  size_image();
  check(gl_.GetError() == GL_NO_ERROR, "a warp loads without an OpenGL error");
}

void GlRenderer::draw_background(const view::Background& background)
{
  gl_.Disable(GL_DEPTH_TEST);
  gl_.UseProgram(background_program_);
  gl_.Uniform3fv(top_, 1, background.top.data());
  gl_.Uniform3fv(bottom_, 1, background.bottom.data());
  gl_.BindVertexArray(empty_array_);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
}

void GlRenderer::draw_occlusion(const view::Scene& scene, const view::Camera& camera, const PixelBox& box)
{
  const bool is_shaded = scene.mode != view::DrawMode::wire && scene.mode != view::DrawMode::hidden_line;
  if (!is_shaded || !(scene.occlusion_radius_mm > 0.0)) return;
  if (!set_.occlusion) set_.occlusion = std::make_unique<OcclusionPainter>(gl_, plan(), set_.drawn);
  const Eigen::Matrix4f projection = view::projection(camera).cast<float>();
  set_.occlusion->draw({box, projection, static_cast<float>(scene.occlusion_radius_mm)}, set_.drawn,
                       empty_array_);
}

void GlRenderer::draw_shot(const view::Scene& scene, std::size_t row, const Shot& shot)
{
  const view::Viewport& view = shot.viewport;
  const PixelBox box{view.x, options_.height - view.y - view.height, view.width, view.height};
  surfaces_->begin(scene, shot.camera, box, is_multisampled());
  const PixelBox used = is_sparse_ ? surfaces_->content_box() : box;
  changed_[row] = is_sparse_ ? bounding_box(used, used_[row]) : box;
  used_[row] = used;
  if (changed_[row].is_empty()) return;
  gl_.Viewport(box.x, box.y, box.width, box.height);
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.Scissor(changed_[row].x, changed_[row].y, changed_[row].width, changed_[row].height);
  if (is_sparse_) gl_.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  // The frame buffer was cleared to black.
  if (!is_black(scene.background)) draw_background(scene.background);
  gl_.Enable(GL_DEPTH_TEST);
  surfaces_->draw(scene, SurfacePass::opaque);
  draw_occlusion(scene, shot.camera, box);
  const bool is_blended = !is_multisampled() && lists_ && lists_->draw(*surfaces_, scene, empty_array_);
  if (!is_blended) set_.peeler->draw(*surfaces_, scene, set_.drawn);
  gl_.Disable(GL_SCISSOR_TEST);
}

bool GlRenderer::finds_srgb_screen() const
{
  if (!context_->has_screen()) return false;
  gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
  GLint encoding = GL_LINEAR;
  gl_.GetFramebufferAttachmentParameteriv(GL_FRAMEBUFFER, GL_BACK_LEFT,
                                          GL_FRAMEBUFFER_ATTACHMENT_COLOR_ENCODING, &encoding);
  return encoding == GL_SRGB;
}

void GlRenderer::draw_frame(const view::Scene& scene, std::span<const Shot> shots, const Overlay* overlay,
                            bool is_for_screen)
{
  context_->make_current();
  // Copying a frame to the window takes as long in software as warping it.
  is_on_screen_ = is_for_screen && warper_ && has_srgb_screen_;
  const unsigned output = is_on_screen_ ? 0 : shown().frame;
  surfaces_->refresh(scene);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, set_.drawn.frame);
  gl_.Enable(GL_FRAMEBUFFER_SRGB);
  const bool can_be_sparse = warper_ && is_black(scene.background);
  is_sparse_ = is_sparse_ && can_be_sparse && used_.size() == shots.size();
  used_.resize(shots.size());
  changed_.resize(shots.size());
  // Without scissors software rendering clears faster.
  if (!is_sparse_) gl_.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  for (std::size_t k = 0; k < shots.size(); ++k) draw_shot(scene, k, shots[k]);
  if (warper_) {
    // The first frame warps all of it, the gaps between the shots too.
    if (!is_sparse_) changed_.assign(1, {0, 0, options_.width, options_.height});
    warper_->draw(set_.drawn.frame, changed_, used_, output);
  }
  is_sparse_ = can_be_sparse;
  is_picture_kept_ = is_multisampled() && !warper_;
  draw_overlay(overlay, output);
}

/// Resolves the samples and draws the overlay over the finished picture.
void GlRenderer::draw_overlay(const Overlay* overlay, unsigned frame)
{
  gl_.Enable(GL_FRAMEBUFFER_SRGB);
  if (is_multisampled() && !warper_)
    blit(set_.drawn.frame, set_.resolved.frame, options_.width, options_.height);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, frame);
  if (overlay != nullptr) overlays_->draw(*overlay, shown_width(), shown_height());
}

/// With GL_FRAMEBUFFER_SRGB enabled samples are averaged in linear light; disabled, values are copied
/// unchanged.
void GlRenderer::blit(unsigned from, unsigned to, int w, int h)
{
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, from);
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, to);
  gl_.BlitFramebuffer(0, 0, w, h, 0, 0, w, h, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

void GlRenderer::read_pixels()
{
  const int w = shown_width(), h = shown_height();
  gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_.ReadPixels(0, 0, w, h, GL_RGBA, GL_UNSIGNED_BYTE, upside_down_.data());
  const std::ptrdiff_t stride = 4 * static_cast<std::ptrdiff_t>(w);
  for (int row = 0; row < h; ++row)
    std::copy_n(upside_down_.begin() + (h - 1 - row) * stride, stride, image_.rgba.begin() + row * stride);
}

const Image& GlRenderer::draw(const view::Scene& scene, std::span<const Shot> shots, const Overlay* overlay)
{
  draw_frame(scene, shots, overlay, false);
  read_pixels();
  check(gl_.GetError() == GL_NO_ERROR, "a frame is drawn without an OpenGL error");
  return image_;
}

void GlRenderer::present(const view::Scene& scene, std::span<const Shot> shots, const Overlay* overlay)
{
  draw_frame(scene, shots, overlay, true);
  show_on_screen();
}

bool GlRenderer::present_again(const Overlay* overlay)
{
  if (!is_picture_kept_) return false;
  context_->make_current();
  is_on_screen_ = false;
  draw_overlay(overlay, shown().frame);
  show_on_screen();
  return true;
}

void GlRenderer::show_on_screen()
{
  if (context_->has_screen() && !is_on_screen_) {
    gl_.Disable(GL_FRAMEBUFFER_SRGB);
    blit(shown().frame, 0, shown_width(), shown_height());
  }
  gl_.Finish();
  check(gl_.GetError() == GL_NO_ERROR, "a frame is shown without an OpenGL error");
}

}  // namespace

const Image& Renderer::draw(const view::Scene& scene, const view::Camera& camera)
{
  const Shot shot{camera, {0, 0, width(), height()}};
  return draw(scene, {&shot, 1}, nullptr);
}

std::unique_ptr<Renderer> make_gl_renderer(std::unique_ptr<GlContext> context, const RenderOptions& options)
{
  return std::make_unique<GlRenderer>(std::move(context), options);
}

std::unique_ptr<Renderer> make_offscreen_renderer(const RenderOptions& options, Backend backend)
{
  return make_gl_renderer(backend == Backend::egl ? make_egl_context() : make_osmesa_context(), options);
}

}  // namespace vrda::view
