#include "ipm_mapping/detectors/comparison.hpp"

#include <cv_bridge/cv_bridge.h>
#include <ipm_mapping/Comparison.h>

#include <boost/make_shared.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <pluginlib/class_list_macros.hpp>

#include "ipm_mapping/parameters/comparison_parameters.hpp"
#include "ipm_mapping/ros/lazy_outputs.hpp"
#include "ipm_mapping/ros/overlay_output.hpp"
#include "ipm_mapping/ros/parameter_loader.hpp"
#include "ipm_mapping/ros/sentence.hpp"
#include "ipm_mapping/ros/stage_messages.hpp"
#include "ipm_mapping/ros/stage_nodelet.hpp"
#include "ipm_mapping/ros/stamp_matcher.hpp"
#include "ipm_mapping/view/overlay.hpp"
#include "ipm_mapping/view/side_by_side.hpp"

namespace ipm_mapping {
namespace {

StageComparison messageOf(const PictureComparison& comparison) {
  StageComparison message;
  message.equal = comparison.equal();
  message.compared = comparison.compared;
  message.changed = comparison.changed;
  message.seen_once = comparison.seen_once;
  message.max = static_cast<float>(comparison.max);
  message.mean = static_cast<float>(comparison.mean);
  return message;
}

ContactComparison messageOf(const PointComparison& comparison) {
  ContactComparison message;
  message.equal = comparison.equal();
  message.points_float = static_cast<std::uint32_t>(comparison.points_a);
  message.points_fixed = static_cast<std::uint32_t>(comparison.points_b);
  message.mean_distance = static_cast<float>(comparison.mean_distance);
  message.max_distance = static_cast<float>(comparison.max_distance);
  return message;
}

std::string thousandths(double metres) { return sentence(std::lround(1e3 * metres), " mm"); }

}  // namespace

/// The float chain beside the FPGA model, stage by stage, frame by frame (the source, §7.2.1,
/// figures 7.5 to 7.9).
class ComparisonNodelet : public StageNodelet {
  enum Topic : std::size_t { Difference, Mask, Answer, FixedDifference, FixedMask, FixedAnswer };
  using Matcher = StampMatcher<DifferenceImage, ObstacleMask, ObstacleArray, DifferenceImage,
                               ObstacleMask, ObstacleArray>;

  /// A frame's messages, opened.
  struct Sides {
    GrayView difference[2], valid[2], mask[2];
    Obstacles answer[2];
  };

  void start() override {
    own_ = loadStruct<ComparisonParameters>(privateNode());
    matcher_.emplace(static_cast<std::size_t>(own_.waiting_frames));
    monitor().expect(node().resolveName("difference"));
    monitor().setAsleep(true);
    comparison_ = outputs_.advertise<Comparison>(node(), "comparison");
    difference_ = outputs_.advertiseImage(node(), "comparison/difference");
    mask_ = outputs_.advertiseImage(node(), "comparison/mask");
    contacts_ = outputs_.advertiseImage(node(), "comparison/contacts");
    pictures_.emplace(node(), privateNode());
  }

  template <std::size_t Index, class Message>
  void listen(const std::string& topic) {
    const boost::function<void(const boost::shared_ptr<const Message>&)> take =
        [this](const boost::shared_ptr<const Message>& message) {
          if (Index == Difference) monitor().received();
          guarded([&] { onMessage<Index>(message); });
        };
    inputs_.push_back(node().subscribe<Message>(topic, static_cast<std::uint32_t>(own_.queue), take,
                                                ros::VoidConstPtr(),
                                                ros::TransportHints().tcpNoDelay()));
  }

  void setAwake(bool awake) {
    monitor().setAsleep(!awake);
    matcher_->clear();
    inputs_.clear();
    if (!awake) return pictures_->want(false);
    listen<Difference, DifferenceImage>("difference");
    listen<Mask, ObstacleMask>("mask");
    listen<Answer, ObstacleArray>("obstacles");
    listen<FixedDifference, DifferenceImage>("fpga/difference");
    listen<FixedMask, ObstacleMask>("fpga/mask");
    listen<FixedAnswer, ObstacleArray>("fpga/obstacles");
  }

  template <std::size_t Index, class Message>
  void onMessage(const boost::shared_ptr<const Message>& message) {
    const auto set = matcher_->add<Index>(message->header.stamp.toNSec(), message);
    monitor().set("incomplete", static_cast<double>(matcher_->incomplete()));
    pictures_->want(contacts_.getNumSubscribers() > 0);
    if (set) compare(*set);
  }

  static Refusal open(const Matcher::Set& set, Sides& sides) {
    Refusal refusal = wrap(*std::get<Difference>(set), sides.difference[0], sides.valid[0]);
    if (!refusal)
      refusal = wrap(*std::get<FixedDifference>(set), sides.difference[1], sides.valid[1]);
    if (!refusal) refusal = wrap(*std::get<Mask>(set), sides.mask[0]);
    if (!refusal) refusal = wrap(*std::get<FixedMask>(set), sides.mask[1]);
    if (!refusal) refusal = fromMessage(*std::get<Answer>(set), sides.answer[0]);
    if (!refusal) refusal = fromMessage(*std::get<FixedAnswer>(set), sides.answer[1]);
    if (!refusal && !sides.mask[0].sameSize(sides.mask[1])) refusal = "sides differ in size";
    if (!refusal && !sides.mask[0].sameSize(sides.difference[0])) refusal = "stages differ in size";
    if (!refusal && !sides.mask[0].sameSize(sides.difference[1])) refusal = "stages differ in size";
    return refusal;
  }

  void compare(const Matcher::Set& set) {
    Sides sides;
    if (const Refusal refusal = open(set, sides)) return monitor().dropped("bad_image", *refusal);
    // A side that lost a frame has another previous frame: that is no matter of word lengths.
    if (std::get<Difference>(set)->view.reference_stamp !=
        std::get<FixedDifference>(set)->view.reference_stamp)
      return monitor().skipped("different_reference");
    auto message = boost::make_shared<Comparison>();
    message->header = std::get<Difference>(set)->header;
    message->frame = std::get<Difference>(set)->frame;
    const auto differences = compareDifferences(sides.difference[0], sides.valid[0],
                                                sides.difference[1], sides.valid[1]);
    const auto masks = compareMasks(sides.mask[0], sides.mask[1]);
    const auto points = compareContacts(sides.answer[0].contacts, sides.answer[1].contacts);
    message->difference = messageOf(differences);
    message->mask = messageOf(masks);
    message->contacts = messageOf(points);
    message->threshold_float = std::get<Mask>(set)->threshold;
    message->threshold_fixed = std::get<FixedMask>(set)->threshold;
    comparison_.publish(message);
    showDifference(sides, *message);
    showMask(sides, *message);
    showContacts(sides, std::get<Difference>(set)->image_stamp, *message);
    monitor().set("changed_mask_pixels", masks.changed);
    monitor().used(message->header.stamp);
  }

  void show(const image_transport::Publisher& publisher, const std_msgs::Header& header,
            const std::vector<Panel>& panels) const {
    publisher.publish(cv_bridge::CvImage(header, "bgr8", sideBySide(panels)).toImageMsg());
  }

  void showDifference(const Sides& sides, const Comparison& c) const {
    if (difference_.getNumSubscribers() == 0) return;
    const std::string times = sentence(", x", own_.gain);
    show(difference_, c.header,
         {{amplified(sides.difference[0], own_.gain), "difference, float" + times},
          {amplified(sides.difference[1], own_.gain), "fixed" + times},
          {differenceOf(sides.difference[0], sides.difference[1], own_.gain),
           sentence("changed ", c.difference.changed, " px, max ", c.difference.max, times)}});
  }

  void showMask(const Sides& sides, const Comparison& c) const {
    if (mask_.getNumSubscribers() == 0) return;
    show(mask_, c.header,
         {{amplified(sides.mask[0], 1), sentence("mask, float, threshold ", c.threshold_float)},
          {amplified(sides.mask[1], 1), sentence("fixed, threshold ", c.threshold_fixed)},
          {differenceOf(sides.mask[0], sides.mask[1], 1),
           sentence("changed ", c.mask.changed, " px, seen once ", c.mask.seen_once)}});
  }

  void showContacts(const Sides& sides, const ros::Time& image_stamp, const Comparison& c) const {
    GrayPicture raw;
    if (contacts_.getNumSubscribers() == 0 || !pictures_->find(image_stamp, raw)) return;
    cv::Mat scene;
    cv::cvtColor(rectified(raw.view, sides.answer[0].view.camera), scene, cv::COLOR_GRAY2BGR);
    cv::Mat pictures[3] = {scene.clone(), scene.clone(), scene};
    const auto& [a, b] = sides.answer;
    markContacts(a.contacts, ContactMark::Ring, own_.contact_size, pictures[0]);
    markContacts(b.contacts, ContactMark::Disk, own_.contact_size, pictures[1]);
    markContacts(a.contacts, ContactMark::Ring, own_.contact_size, pictures[2]);
    markContacts(b.contacts, ContactMark::Disk, own_.contact_size, pictures[2]);
    show(contacts_, c.header,
         {{pictures[0], sentence("contacts, float: ", a.contacts.size())},
          {pictures[1], sentence("fixed: ", b.contacts.size())},
          {pictures[2], a.contacts.empty() || b.contacts.empty()
                            ? "both"
                            : "both, mean distance " + thousandths(c.contacts.mean_distance)}});
  }

  ComparisonParameters own_;
  std::optional<Matcher> matcher_;
  std::vector<ros::Subscriber> inputs_;
  LazyOutputs outputs_{[this](bool awake) { setAwake(awake); }};
  std::optional<CameraPictures> pictures_;
  ros::Publisher comparison_;
  image_transport::Publisher difference_, mask_, contacts_;
};

}  // namespace ipm_mapping

PLUGINLIB_EXPORT_CLASS(ipm_mapping::ComparisonNodelet, nodelet::Nodelet)
