#include "view/gl_translucency.hpp"

#include <GL/glcorearb.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "view/shaders.hpp"

namespace vrda::view {

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
