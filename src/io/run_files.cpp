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

void writeTrajectory(const std::string& directory, const std::vector<TrackedFrame>& frames) {
  std::ofstream file = create(directory + "/trajectory.csv");
  file << "stamp,frame,x_odom,y_odom,theta_odom,x_refined,y_refined,theta_refined,"
          "var_x,cov_xy,cov_xtheta,var_y,cov_ytheta,var_theta\n";
  char line[512];
  for (const TrackedFrame& f : frames) {
    const SE2 &o = f.T_odom_base, &r = f.refined.T_odom_base;
    const Eigen::Matrix3d& C = f.refined.covariance;
    std::snprintf(line, sizeof line,
                  "%.9f,%llu,%.6f,%.6f,%.7f,%.6f,%.6f,%.7f,%.4e,%.4e,%.4e,%.4e,%.4e,%.4e\n",
                  f.stamp, static_cast<unsigned long long>(f.frame), o.x, o.y, o.theta, r.x, r.y,
                  r.theta, C(0, 0), C(0, 1), C(0, 2), C(1, 1), C(1, 2), C(2, 2));
    file << line;
  }
  file.close();
  if (!file)
    throw std::runtime_error("cannot write '" + directory + "/trajectory.csv': is the disk full?");
}

}  // namespace ipm_mapping
