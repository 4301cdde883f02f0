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

  /// Where moving things are in the pictures that follow.
  void moveTo(double time);

  /// Linear radiance of each pixel, row-major; the buffer is resized. One ray a pixel, sixteen
  /// where two surfaces meet in it or in its mirror image.
  void render(const RowPose& T_world_camera, std::vector<float>& radiance);

 private:
  struct View {
    Eigen::Matrix3f turn;
    Eigen::Vector3f origin;
  };
  [[nodiscard]] PixelRay rayOf(int u, int v) const;
  /// A part of a pixel that shows one surface: its middle ray stands for all of it.
  struct Part {
    PixelRay ray;
    Hit hit;
    int surface = kNothing, middle = 0;
    float weight = 1.0F;  ///< share of the light along the ray that is seen
    float share = 0.0F;   ///< share of the pixel
    unsigned members = 0;
    std::size_t pixel = 0;
  };
  using Parts = std::vector<Part>;

  unsigned setBlock(int u0, int v0, PixelRays& rays) const;
  void renderBlock(int u0, int v0, std::vector<float>& radiance);
  void addMirrors(const std::size_t* pixels, unsigned members, Mirrors& mirrors,
                  std::vector<float>& radiance);
  [[nodiscard]] bool isEdge(int u, int v) const;
  void smoothEdges(std::vector<float>& radiance);
  void queuePixel(int u, int v);
  void queueMirror(const Part& part, const PixelRay& mirror, float share);
  void queueParts(const PixelRays& rays, unsigned members, const Part& whole, Parts& queue) const;
  void shadeQueues(std::vector<float>& radiance);
  void shadeParts(const Parts& parts, std::vector<float>& radiance);
  std::size_t shadePacket(const Parts& parts, std::size_t first, std::vector<float>& radiance);

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
  Parts parts_, mirrored_parts_;      ///< of edge pixels, to be shaded
  std::vector<std::uint64_t> order_;
};

}  // namespace ipm_mapping::sim
