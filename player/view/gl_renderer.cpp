// Draws scenes by OpenGL into a frame buffer: background, opaque and translucent surfaces, overlay,
// distortion.
#include "view/gl_renderer.hpp"

#include <GL/glcorearb.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "core/text.hpp"
#include "view/gl_context.hpp"
#include "view/gl_mesh.hpp"
#include "view/gl_table.hpp"
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

namespace {

/// Of the extension EXT_texture_sRGB_decode.
constexpr GLenum texture_srgb_decode = 0x8A48;
constexpr GLint skip_decode = 0x8A4A;

}  // namespace

OverlayPainter::OverlayPainter(const GlTable& gl) : gl_(gl)
{
  program_ = linked_program(gl_, "#version 330 core\n", overlay_vertex_shader, overlay_fragment_shader);
  size_px_ = gl_.GetUniformLocation(program_, "size_px");
  gl_.GenVertexArrays(1, &vertex_array_);
  gl_.GenBuffers(2, buffers_.data());
  gl_.BindVertexArray(vertex_array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, buffers_[0]);
  gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers_[1]);
  for (GLuint i = 0; i < 3; ++i) gl_.EnableVertexAttribArray(i);
  constexpr GLsizei stride = sizeof(OverlayVertex);
  gl_.VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, stride, buffer_offset(offsetof(OverlayVertex, x_px)));
  gl_.VertexAttribPointer(1, 2, GL_FLOAT, GL_FALSE, stride, buffer_offset(offsetof(OverlayVertex, u)));
  gl_.VertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, stride,
                          buffer_offset(offsetof(OverlayVertex, colour)));
}

OverlayPainter::~OverlayPainter()
{
  gl_.DeleteTextures(1, &font_);
  gl_.DeleteBuffers(2, buffers_.data());
  gl_.DeleteVertexArrays(1, &vertex_array_);
  gl_.DeleteProgram(program_);
}

void OverlayPainter::load(const OverlayFont& font)
{
  check(font.coverage.size() == static_cast<std::size_t>(font.width) * static_cast<std::size_t>(font.height),
        "a font image has one byte per pixel");
  if (font_ == 0) gl_.GenTextures(1, &font_);
  gl_.BindTexture(GL_TEXTURE_2D, font_);
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_R8, font.width, font.height, 0, GL_RED, GL_UNSIGNED_BYTE,
                 font.coverage.data());
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

void OverlayPainter::upload(const Overlay& overlay)
{
  const auto fill = [&](std::size_t i, GLenum kind, std::size_t n_bytes, const void* data) {
    const auto size = static_cast<GLsizeiptr>(n_bytes);
    // Twice the required size, so that a growing overlay does not reallocate every frame.
    if (size > room_bytes_[i]) room_bytes_[i] = 2 * size;
    // Orphan the previous storage, which the GPU may still be reading.
    gl_.BufferData(kind, room_bytes_[i], nullptr, GL_STREAM_DRAW);
    gl_.BufferSubData(kind, 0, size, data);
  };
  gl_.BindBuffer(GL_ARRAY_BUFFER, buffers_[0]);
  fill(0, GL_ARRAY_BUFFER, overlay.vertices.size() * sizeof(OverlayVertex), overlay.vertices.data());
  fill(1, GL_ELEMENT_ARRAY_BUFFER, overlay.indices.size() * sizeof(std::uint32_t), overlay.indices.data());
}

void OverlayPainter::draw(const Overlay& overlay, int width, int height)
{
  if (overlay.commands.empty() || overlay.indices.empty()) return;
  check(font_ != 0, "a font is loaded before an overlay is drawn");
  gl_.UseProgram(program_);
  gl_.Uniform2f(size_px_, static_cast<float>(width), static_cast<float>(height));
  gl_.BindTexture(GL_TEXTURE_2D, font_);
  gl_.BindVertexArray(vertex_array_);
  upload(overlay);
  gl_.Viewport(0, 0, width, height);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.Enable(GL_BLEND);
  gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  gl_.Enable(GL_SCISSOR_TEST);
  const auto pixel = [](float value_px, int most) {
    return static_cast<int>(std::clamp(value_px, 0.0F, static_cast<float>(most)));
  };
  for (const OverlayCommand& command : overlay.commands) {
    check(std::size_t{command.first_index} + command.n_indices <= overlay.indices.size(),
          "an overlay's commands are within its indices");
    const int left = pixel(command.clip_px[0], width), top = pixel(command.clip_px[1], height);
    const int right = pixel(command.clip_px[2], width), bottom = pixel(command.clip_px[3], height);
    if (right <= left || bottom <= top) continue;
    gl_.Scissor(left, height - bottom, right - left, bottom - top);
    gl_.DrawElementsBaseVertex(GL_TRIANGLES, static_cast<GLsizei>(command.n_indices), GL_UNSIGNED_INT,
                               buffer_offset(command.first_index * sizeof(std::uint32_t)),
                               static_cast<GLint>(command.first_vertex));
  }
  gl_.Disable(GL_SCISSOR_TEST);
  gl_.Disable(GL_BLEND);
}

WarpPainter::WarpPainter(const GlTable& gl, const view::Warp& warp, int picture_width, int picture_height)
    : gl_(gl),
      mesh_(warp.mesh),
      width_(warp.width),
      height_(warp.height),
      picture_width_(picture_width),
      picture_height_(picture_height)
{
  program_ = linked_program(gl_, "#version 330 core\n", warp_vertex_shader, warp_fragment_shader);
  gl_.UseProgram(program_);
  gl_.Uniform2f(gl_.GetUniformLocation(program_, "size_px"), static_cast<float>(width_),
                static_cast<float>(height_));
  upload(warp.mesh);
  gl_.GenTextures(1, &picture_texture_);
  gl_.BindTexture(GL_TEXTURE_2D, picture_texture_);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8_ALPHA8, picture_width, picture_height, 0, GL_RGBA,
                 GL_UNSIGNED_BYTE, nullptr);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  gl_.TexParameteri(GL_TEXTURE_2D, texture_srgb_decode, skip_decode);
  is_encoded_ = gl_.GetError() == GL_NO_ERROR;
  gl_.GenFramebuffers(1, &picture_);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, picture_);
  gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, picture_texture_, 0);
  warped_ = create_target(gl_, {width_, height_, 0, false});
}

WarpPainter::~WarpPainter()
{
  destroy_target(gl_, warped_);
  gl_.DeleteFramebuffers(1, &picture_);
  gl_.DeleteTextures(1, &picture_texture_);
  gl_.DeleteBuffers(2, buffers_.data());
  gl_.DeleteVertexArrays(1, &vertex_array_);
  gl_.DeleteProgram(program_);
}

void WarpPainter::upload(const view::WarpMesh& mesh)
{
  for (const std::uint32_t k : mesh.triangles)
    check(k < mesh.vertices.size(), "a warp's triangles are within its vertices");
  n_indices_ = static_cast<int>(mesh.triangles.size());
  gl_.GenVertexArrays(1, &vertex_array_);
  gl_.GenBuffers(2, buffers_.data());
  gl_.BindVertexArray(vertex_array_);
  gl_.BindBuffer(GL_ARRAY_BUFFER, buffers_[0]);
  gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers_[1]);
  gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh.vertices.size() * sizeof(view::WarpVertex)),
                 mesh.vertices.data(), GL_STATIC_DRAW);
  gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER,
                 static_cast<GLsizeiptr>(mesh.triangles.size() * sizeof(std::uint32_t)),
                 mesh.triangles.data(), GL_STATIC_DRAW);
  for (GLuint i = 0; i < 2; ++i) gl_.EnableVertexAttribArray(i);
  constexpr GLsizei stride = sizeof(view::WarpVertex);
  gl_.VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, stride, buffer_offset(offsetof(view::WarpVertex, x_px)));
  gl_.VertexAttribPointer(1, 2, GL_FLOAT, GL_FALSE, stride, buffer_offset(offsetof(view::WarpVertex, u)));
}

/// Bounds of the triangles that sample a box of the picture, with a pixel of margin for interpolation.
PixelBox WarpPainter::warped_box(const PixelBox& used) const
{
  const auto w = static_cast<float>(picture_width_), h = static_cast<float>(picture_height_);
  const float left = static_cast<float>(used.x) - 1.0F,
              right = static_cast<float>(used.x + used.width) + 1.0F;
  const float top = h - static_cast<float>(used.y + used.height) - 1.0F,
              bottom = h - static_cast<float>(used.y) + 1.0F;
  float low_x = static_cast<float>(width_), low_y = static_cast<float>(height_), high_x = 0.0F, high_y = 0.0F;
  for (std::size_t k = 0; k + 2 < mesh_.triangles.size(); k += 3) {
    const std::array<const view::WarpVertex*, 3> corners{&mesh_.vertices[mesh_.triangles[k]],
                                                         &mesh_.vertices[mesh_.triangles[k + 1]],
                                                         &mesh_.vertices[mesh_.triangles[k + 2]]};
    const auto [u0, u1] = std::minmax({corners[0]->u, corners[1]->u, corners[2]->u});
    const auto [v0, v1] = std::minmax({corners[0]->v, corners[1]->v, corners[2]->v});
    if (u1 * w < left || u0 * w > right || v1 * h < top || v0 * h > bottom) continue;
    for (const view::WarpVertex* const corner : corners) {
      low_x = std::min(low_x, corner->x_px);
      low_y = std::min(low_y, corner->y_px);
      high_x = std::max(high_x, corner->x_px);
      high_y = std::max(high_y, corner->y_px);
    }
  }
  if (high_x <= low_x || high_y <= low_y) return {};
  const int x = static_cast<int>(std::floor(low_x)), y = static_cast<int>(std::floor(low_y));
  const int width = static_cast<int>(std::ceil(high_x)) - x, height = static_cast<int>(std::ceil(high_y)) - y;
  return {x, height_ - y - height, width, height};
}

void WarpPainter::draw(unsigned picture, std::span<const PixelBox> changed, std::span<const PixelBox> used,
                       unsigned to)
{
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, picture);
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, picture_);
  for (const PixelBox& box : changed) {
    if (box.is_empty()) continue;
    const int right = box.x + box.width, top = box.y + box.height;
    gl_.BlitFramebuffer(box.x, box.y, right, top, box.x, box.y, right, top, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  }
  gl_.BindFramebuffer(GL_FRAMEBUFFER, to);
  gl_.Viewport(0, 0, width_, height_);
  gl_.Clear(GL_COLOR_BUFFER_BIT);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.UseProgram(program_);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, picture_texture_);
  gl_.BindVertexArray(vertex_array_);
  gl_.Enable(GL_SCISSOR_TEST);
  if (is_encoded_) gl_.Disable(GL_FRAMEBUFFER_SRGB);
  for (const PixelBox& box : used) {
    const PixelBox out = box.is_empty() ? PixelBox{} : warped_box(box);
    if (out.is_empty()) continue;
    gl_.Scissor(out.x, out.y, out.width, out.height);
    gl_.DrawElements(GL_TRIANGLES, n_indices_, GL_UNSIGNED_INT, nullptr);
  }
  gl_.Enable(GL_FRAMEBUFFER_SRGB);
  gl_.Disable(GL_SCISSOR_TEST);
}

OcclusionPainter::OcclusionPainter(const GlTable& gl, const TargetPlan& plan, const Target& drawn)
    : gl_(gl), plan_(plan), half_width_((plan.width + 1) / 2), half_height_((plan.height + 1) / 2)
{
  if (plan.samples > 0) depth_ = create_target(gl_, {plan.width, plan.height, 0});
  gl_.GenFramebuffers(1, &colour_frame_);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, colour_frame_);
  gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, drawn.colour);
  found_ = create_half_layer();
  smoothed_ = create_half_layer();
  const char* const first = "#version 330 core\n";
  find_program_ = linked_program(gl_, first, background_vertex_shader, occlusion_fragment_shader);
  smooth_program_ = linked_program(gl_, first, background_vertex_shader, smoothing_fragment_shader);
  apply_program_ = linked_program(gl_, first, background_vertex_shader, darkening_fragment_shader);
}

OcclusionPainter::~OcclusionPainter()
{
  destroy_target(gl_, depth_);
  gl_.DeleteFramebuffers(1, &colour_frame_);
  for (const Layer& layer : {found_, smoothed_}) {
    gl_.DeleteFramebuffers(1, &layer.frame);
    gl_.DeleteTextures(1, &layer.texture);
  }
  for (const unsigned program : {find_program_, smooth_program_, apply_program_}) gl_.DeleteProgram(program);
}

OcclusionPainter::Layer OcclusionPainter::create_half_layer() const
{
  Layer layer;
  gl_.GenTextures(1, &layer.texture);
  gl_.BindTexture(GL_TEXTURE_2D, layer.texture);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RG16F, half_width_, half_height_, 0, GL_RG, GL_FLOAT, nullptr);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl_.GenFramebuffers(1, &layer.frame);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, layer.frame);
  gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, layer.texture, 0);
  return layer;
}

void OcclusionPainter::pass(unsigned program, const View& view, unsigned texture, unsigned empty_array) const
{
  const auto at = [&](const char* name) { return gl_.GetUniformLocation(program, name); };
  gl_.UseProgram(program);
  gl_.BindTexture(GL_TEXTURE_2D, texture);
  gl_.Uniform1i(at("source"), 0);
  gl_.Uniform1f(at("radius_mm"), view.radius_mm);
  gl_.Uniform2f(at("corner_px"), static_cast<float>(view.box.x), static_cast<float>(view.box.y));
  gl_.Uniform2f(at("size_px"), static_cast<float>(view.box.width), static_cast<float>(view.box.height));
  gl_.UniformMatrix4fv(at("projection"), 1, GL_FALSE, view.projection.data());
  gl_.BindVertexArray(empty_array);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
}

void OcclusionPainter::draw(const View& view, const Target& drawn, unsigned empty_array)
{
  const PixelBox& box = view.box;
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.Disable(GL_DEPTH_TEST);
  if (plan_.samples > 0) {
    gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, drawn.frame);
    gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, depth_.frame);
    gl_.BlitFramebuffer(0, 0, plan_.width, plan_.height, 0, 0, plan_.width, plan_.height, GL_DEPTH_BUFFER_BIT,
                        GL_NEAREST);
  }
  const PixelBox half{box.x / 2, box.y / 2, (box.x + box.width + 1) / 2 - box.x / 2,
                      (box.y + box.height + 1) / 2 - box.y / 2};
  gl_.Viewport(half.x, half.y, half.width, half.height);
  gl_.Scissor(half.x, half.y, half.width, half.height);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, found_.frame);
  pass(find_program_, view, plan_.samples > 0 ? depth_.depth : drawn.depth, empty_array);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, smoothed_.frame);
  pass(smooth_program_, view, found_.texture, empty_array);
  gl_.Viewport(box.x, box.y, box.width, box.height);
  gl_.Scissor(box.x, box.y, box.width, box.height);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, colour_frame_);
  gl_.Enable(GL_BLEND);
  gl_.BlendFuncSeparate(GL_ZERO, GL_SRC_COLOR, GL_ZERO, GL_ONE);
  pass(apply_program_, view, smoothed_.texture, empty_array);
  gl_.Disable(GL_BLEND);
  gl_.Enable(GL_DEPTH_TEST);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, drawn.frame);
}

LayerPeeler::LayerPeeler(const GlTable& gl, const TargetPlan& plan, const Target& drawn)
    : gl_(gl), is_multisampled_(plan.samples > 0)
{
  for (Target& layer : layers_) layer = create_layer_target(gl_, plan, drawn);
  gl_.GenQueries(1, &query_);
  gl_.GenQueries(1, &last_query_);
}

LayerPeeler::~LayerPeeler()
{
  for (Target& layer : layers_) destroy_target(gl_, layer);
  gl_.DeleteQueries(1, &query_);
  gl_.DeleteQueries(1, &last_query_);
}

bool LayerPeeler::is_found(unsigned query) const
{
  GLuint is_found = 0;
  gl_.GetQueryObjectuiv(query, GL_QUERY_RESULT, &is_found);
  return is_found != 0;
}

void LayerPeeler::peel(SurfacePainter& surfaces, const view::Scene& scene, unsigned behind, unsigned query)
{
  gl_.BindTexture(is_multisampled_ ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D, behind);
  gl_.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  gl_.DepthMask(GL_TRUE);
  gl_.DepthFunc(GL_GREATER);
  gl_.Clear(GL_DEPTH_BUFFER_BIT);
  if (query != 0) gl_.BeginQuery(GL_ANY_SAMPLES_PASSED, query);
  surfaces.draw(scene, SurfacePass::translucent_depth);
  if (query != 0) gl_.EndQuery(GL_ANY_SAMPLES_PASSED);
  gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

void LayerPeeler::draw(SurfacePainter& surfaces, const view::Scene& scene, const Target& drawn)
{
  const PixelBox& box = surfaces.translucent_box();
  if (box.width <= 0 || box.height <= 0) return;
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.Scissor(box.x, box.y, box.width, box.height);
  gl_.ClearDepth(0.0);
  gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  // Reading a query waits until the layer is drawn. Therefore as many layers as in the previous frame are
  // drawn without queries (an empty one draws nothing), and the query of the last one is read a frame later.
  if (n_expected_ > 0 && !is_found(last_query_)) --n_expected_;
  unsigned behind = drawn.depth;
  for (int i = 0; i < most_layers; ++i) {
    const Target& layer = layers_[static_cast<std::size_t>(i % 2)];
    gl_.BindFramebuffer(GL_FRAMEBUFFER, layer.frame);
    const bool is_expected = i < n_expected_;
    const bool is_last_expected = i + 1 == n_expected_;
    peel(surfaces, scene, behind, is_last_expected ? last_query_ : is_expected ? 0 : query_);
    if (!is_expected) {
      if (!is_found(query_)) break;
      n_expected_ = i + 1;
      std::swap(query_, last_query_);
    }
    gl_.DepthMask(GL_FALSE);
    gl_.DepthFunc(GL_EQUAL);
    gl_.Enable(GL_BLEND);
    surfaces.draw(scene, SurfacePass::translucent_colour);
    gl_.Disable(GL_BLEND);
    behind = layer.depth;
  }
  gl_.DepthMask(GL_TRUE);
  gl_.DepthFunc(GL_LESS);
  gl_.ClearDepth(1.0);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, drawn.frame);
}

namespace {

/// Next node, depth, and colour in two words.
constexpr std::size_t node_bytes = 16;

/// Initial capacity per pixel: transparent bones have about four fragments in half of the image.
constexpr std::size_t first_nodes_a_pixel = 2;

}  // namespace

bool FragmentLists::is_supported(const GlTable& gl)
{
  GLint major = 0, minor = 0, n_blocks = 0;
  gl.GetIntegerv(GL_MAJOR_VERSION, &major);
  gl.GetIntegerv(GL_MINOR_VERSION, &minor);
  if (10 * major + minor < 43 || gl.MemoryBarrier == nullptr) return false;
  gl.GetIntegerv(GL_MAX_FRAGMENT_SHADER_STORAGE_BLOCKS, &n_blocks);
  return n_blocks >= 3;
}

FragmentLists::FragmentLists(const GlTable& gl) : gl_(gl)
{
  GLint most_bytes = 0;
  gl_.GetIntegerv(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most_bytes);
  most_nodes_ = static_cast<std::size_t>(std::max(most_bytes, 0)) / node_bytes;
}

FragmentLists::~FragmentLists()
{
  const std::array<unsigned, 3> buffers{heads_, nodes_, count_};
  gl_.DeleteBuffers(static_cast<GLsizei>(buffers.size()), buffers.data());
  gl_.DeleteProgram(blend_program_);
}

void FragmentLists::resize(int width, int height)
{
  width_ = static_cast<unsigned>(width);
  height_ = static_cast<unsigned>(height);
  is_open_ = false;
}

void FragmentLists::open()
{
  if (blend_program_ == 0) {
    const std::string first =
        "#version 430 core\n#define MOST_LAYERS " + std::to_string(LayerPeeler::most_layers) + "\n";
    blend_program_ = linked_program(gl_, first.c_str(), background_vertex_shader, blend_fragment_shader);
    for (unsigned* buffer : {&heads_, &nodes_, &count_}) gl_.GenBuffers(1, buffer);
  }
  clear_heads();
  reserve(std::size_t{first_nodes_a_pixel} * width_ * height_);
  is_open_ = true;
}

void FragmentLists::clear_heads()
{
  const std::vector<std::uint32_t> none(static_cast<std::size_t>(width_) * height_, 0U);
  gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, heads_);
  gl_.BufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(none.size() * sizeof(std::uint32_t)),
                 none.data(), GL_DYNAMIC_COPY);
}

void FragmentLists::reserve(std::size_t n_nodes)
{
  capacity_ = std::min(n_nodes, most_nodes_);
  gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, nodes_);
  gl_.BufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(capacity_ * node_bytes), nullptr,
                 GL_DYNAMIC_COPY);
}

/// Fills the lists; returns the number of nodes required, which may exceed the capacity.
std::size_t FragmentLists::store(SurfacePainter& surfaces, const view::Scene& scene)
{
  // Node 0 is the end of every list.
  const std::array<std::uint32_t, 2> begun{1U, width_};
  gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, count_);
  gl_.BufferData(GL_SHADER_STORAGE_BUFFER, sizeof(begun), begun.data(), GL_DYNAMIC_READ);
  gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, heads_);
  gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, nodes_);
  gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, count_);
  gl_.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  gl_.DepthMask(GL_FALSE);
  surfaces.draw(scene, SurfacePass::translucent_store);
  gl_.DepthMask(GL_TRUE);
  gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  gl_.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  std::uint32_t n_nodes = 0;
  gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, count_);
  gl_.GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, sizeof(n_nodes), &n_nodes);
  return n_nodes;
}

bool FragmentLists::draw(SurfacePainter& surfaces, const view::Scene& scene, unsigned empty_array)
{
  const PixelBox& box = surfaces.translucent_box();
  if (box.width <= 0 || box.height <= 0) return true;
  if (!is_open_) open();
  gl_.Scissor(box.x, box.y, box.width, box.height);
  const std::size_t n_nodes = store(surfaces, scene);
  if (n_nodes > capacity_) {
    clear_heads();
    if (n_nodes > most_nodes_) return false;
    reserve(2 * n_nodes);
    store(surfaces, scene);
  }
  gl_.Disable(GL_DEPTH_TEST);
  gl_.Enable(GL_BLEND);
  gl_.BlendFuncSeparate(GL_ONE, GL_SRC_ALPHA, GL_ZERO, GL_ONE);
  gl_.UseProgram(blend_program_);
  gl_.BindVertexArray(empty_array);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
  gl_.Disable(GL_BLEND);
  gl_.Enable(GL_DEPTH_TEST);
  return true;
}

}  // namespace vrda::view
