#pragma once
// From a scene and a camera's place to the light on each pixel.

#include <functional>
#include <vector>

#include "ipm_mapping_sim/lens.hpp"
#include "ipm_mapping_sim/shader.hpp"

namespace ipm_mapping::sim {

/// World pose of the camera while a row is exposed.
using RowPose = std::function<CameraPose(int row)>;

class Renderer {
 public:
  explicit Renderer(const Scene& scene);

  [[nodiscard]] const Stage& stage() const { return stage_; }
  [[nodiscard]] const Lens& lens() const { return lens_; }

  /// Linear radiance of each pixel, row-major; the buffer is resized. One ray a pixel, sixteen
  /// where two surfaces meet in it or in its mirror image.
  void render(const RowPose& T_world_camera, std::vector<float>& radiance);

 private:
  struct View {
    Eigen::Matrix3f turn;
    Eigen::Vector3f origin;
  };
  [[nodiscard]] PixelRay rayOf(int u, int v, float du, float dv) const;
  void renderBlock(int u0, int v0, std::vector<float>& radiance);
  void addMirrors(int u0, int v0, const Mirror* mirrors, std::vector<float>& radiance);
  void smoothEdges(std::vector<float>& radiance);
  [[nodiscard]] bool isEdge(int u, int v) const;
  [[nodiscard]] float smoothed(int u, int v);
  [[nodiscard]] float shadeGroup(const PixelRay* rays, const Hit* hits, unsigned members);
  [[nodiscard]] float mirroredLight(const PixelRay* rays, unsigned members);
  [[nodiscard]] std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(lens_.width()) +
           static_cast<std::size_t>(u);
  }

  const Scene scene_;
  Stage stage_;
  Lens lens_;
  Shader shader_;
  std::vector<View> views_;
  std::vector<int> seen_, mirrored_;  ///< surface of each pixel, and of its mirror image
};

}  // namespace ipm_mapping::sim
