#include "ipm_mapping/io/run_files.hpp"

#include <cstdio>
#include <stdexcept>

namespace ipm_mapping {
namespace {

std::ofstream create(const std::string& path) {
  std::ofstream file(path);
  if (!file) throw std::runtime_error("cannot write '" + path + "'");
  return file;
}

}  // namespace

RunFiles::RunFiles(const std::string& directory)
    : directory_(directory),
      points_csv_(create(directory + "/points.csv")),
      obstacles_csv_(create(directory + "/obstacles.csv")) {
  points_csv_ << "stamp,frame,bearing,u,v,x_base,y_base,x_odom,y_odom\n";
  obstacles_csv_ << "stamp,frame,bearing,angle_rad,density,range_m,state\n";
}

void RunFiles::add(const Obstacles& obstacles) {
  char line[256];
  const double stamp = obstacles.view.stamp;
  const auto frame = static_cast<unsigned long long>(obstacles.frame);
  for (const Contact& c : obstacles.contacts) {
    const Eigen::Vector2d p_odom = obstacles.view.T_odom_base * c.p_base.cast<double>();
    std::snprintf(line, sizeof line, "%.9f,%llu,%d,%.2f,%.2f,%.5f,%.5f,%.5f,%.5f\n", stamp, frame,
                  c.bearing, static_cast<double>(c.u), static_cast<double>(c.v),
                  static_cast<double>(c.p_base.x()), static_cast<double>(c.p_base.y()), p_odom.x(),
                  p_odom.y());
    points_csv_ << line;
  }
  points_ += obstacles.contacts.size();
  for (std::size_t i = 0; i < obstacles.bearings.size(); ++i) {
    const Bearing& b = obstacles.bearings[i];
    std::snprintf(line, sizeof line, "%.9f,%llu,%zu,%.5f,%.4f,%.4f,%s\n", stamp, frame, i,
                  static_cast<double>(b.angle), static_cast<double>(b.density),
                  static_cast<double>(b.range), name(b.state));
    obstacles_csv_ << line;
  }
}

void RunFiles::finish() {
  points_csv_.close();
  obstacles_csv_.close();
  if (!points_csv_ || !obstacles_csv_)
    throw std::runtime_error("cannot write the tables in '" + directory_ + "': is the disk full?");
}

}  // namespace ipm_mapping
