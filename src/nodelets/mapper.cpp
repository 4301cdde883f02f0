#include <ipm_mapping/ObstacleArray.h>
#include <ipm_mapping/SaveMap.h>
#include <std_srvs/Trigger.h>

#include <optional>
#include <pluginlib/class_list_macros.hpp>

#include "ipm_mapping/mapping/localized_map.hpp"
#include "ipm_mapping/ros/map_frame.hpp"
#include "ipm_mapping/ros/map_keeper.hpp"
#include "ipm_mapping/ros/map_outputs.hpp"
#include "ipm_mapping/ros/parameter_loader.hpp"
#include "ipm_mapping/ros/stage_messages.hpp"
#include "ipm_mapping/ros/stage_nodelet.hpp"
#include "ipm_mapping/ros/stamp_order.hpp"
#include "ipm_mapping/ros/trajectory_output.hpp"

namespace ipm_mapping {

/// Obstacles in, occupancy map out (the source, §5.4.2). Never lazy: it remembers.
class Mapper : public StageNodelet {
  void start() override {
    parameters_ = loadStruct<MapperParameters>(privateNode());
    map_.emplace(loadParameters(privateNode()).map);
    keeper_.emplace(*map_, parameters_);
    if (const auto notice = keeper_->makeFolder()) monitor().warn(*notice);
    if (const auto notice = keeper_->loadInitialMap()) monitor().warn(*notice);
    map_frame_.emplace(node(), parameters_);
    localized_.emplace(*map_, map_frame_->moves() ? parameters_.correction : MapCorrection::Keep,
                       parameters_.correction_frames);
    outputs_.emplace(node(), *map_, parameters_);
    trajectory_.emplace(node());
    outputs_->setHeader(map_frame_->name(), ros::Time::now());
    outputs_->publishAll();
    save_ = node().advertiseService("save_map", &Mapper::onSave, this);
    reset_ = node().advertiseService("reset_map", &Mapper::onReset, this);
    if (parameters_.publish_rate > 0.0)
      every(1.0 / parameters_.publish_rate, publisher_, [this] { publish(); });
    if (parameters_.autosave_period > 0.0)
      every(parameters_.autosave_period, autosaver_, [this] {
        if (const auto error = keeper_->autosave()) monitor().warn("autosave: " + *error);
      });
    const auto queue = static_cast<std::uint32_t>(loadStruct<StageParameters>(privateNode()).queue);
    obstacles_ = node().subscribe("obstacles", queue, &Mapper::onObstacles, this,
                                  ros::TransportHints().tcpNoDelay());
    monitor().expect(obstacles_.getTopic());
  }

  void onObstacles(const ObstacleArrayConstPtr& input) {
    monitor().received();
    guarded([&] { process(*input); });
  }

  void process(const ObstacleArray& input) {
    if (const Refusal refusal = fromMessage(input, answer_))
      return monitor().dropped("bad_obstacles", *refusal);
    SE2 T_map_odom;
    if (const Refusal refusal = map_frame_->place(input.view.odom_frame, input.header.stamp,
                                                  map_->geometry().empty(), T_map_odom))
      return monitor().dropped("other_frame", *refusal);
    const StampVerdict verdict = order_.judge(input.header.stamp);
    if (verdict == StampVerdict::Late)
      return monitor().dropped("out_of_order", "obstacles are not newer than the ones before them");
    if (verdict == StampVerdict::Jump) onClockJump();
    const SE2 T_map_base = T_map_odom * answer_.view.T_odom_base;
    outputs_->setRobot({T_map_base.x, T_map_base.y});
    if (answer_.age > 0.0F) return monitor().skipped("remembered");
    if (localized_->update(answer_, T_map_odom)) monitor().count("corrections");
    outputs_->setHeader(map_frame_->name(), input.header.stamp);
    trajectory_->add(map_frame_->name(), input.header.stamp, T_map_base);
    keeper_->touch();
    if (parameters_.publish_rate == 0.0) publish();
    const MapGeometry& geometry = map_->geometry();
    monitor().set("map_width_m", geometry.width * geometry.resolution);
    monitor().set("map_height_m", geometry.height * geometry.resolution);
    monitor().used(input.header.stamp);
  }

  void publish() {
    outputs_->publishChanges();
    trajectory_->publish();
  }

  void onClockJump() {
    monitor().count("resets");
    trajectory_->clear();
    localized_->forget();
    if (!parameters_.clear_on_clock_jump) return;
    clear();
    monitor().warn("the clock was set back: the map is cleared");
  }

  void clear() {
    localized_->clear();
    keeper_->touch();
  }

  bool onSave(SaveMap::Request& request, SaveMap::Response& response) {
    const MapKeeper::Saved saved = keeper_->save(request.name.empty() ? "map" : request.name);
    response.success = !saved.error;
    response.message = saved.error.value_or(saved.path);
    return true;
  }

  bool onReset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    clear();
    trajectory_->clear();
    outputs_->publishAll();
    response.success = 1;
    response.message = "the map is empty";
    return true;
  }

  MapperParameters parameters_;
  std::optional<OccupancyMap> map_;
  std::optional<MapKeeper> keeper_;
  std::optional<LocalizedMap> localized_;
  std::optional<MapFrame> map_frame_;
  std::optional<MapOutputs> outputs_;
  std::optional<TrajectoryOutput> trajectory_;
  Obstacles answer_;
  StampOrder order_;
  ros::ServiceServer save_, reset_;
  ros::WallTimer publisher_, autosaver_;
  ros::Subscriber obstacles_;
};

}  // namespace ipm_mapping

PLUGINLIB_EXPORT_CLASS(ipm_mapping::Mapper, nodelet::Nodelet)
