#pragma once

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <deque>
#include <memory>
#include <stdexcept>
#include <string>

namespace mass_spring {

/// A bag that no run can be taken out of; says why.
class BagError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The messages of one topic in order, one at a time: a recording may be larger than the memory.
template <class Message>
class BagTopic {
 public:
  /// @param bags  that outlive this
  /// @throws BagError if the topic is of another type
  BagTopic(const std::deque<rosbag::Bag>& bags, const std::string& topic)
      : topic_(topic), view_(std::make_unique<rosbag::View>()) {
    for (const rosbag::Bag& bag : bags) view_->addQuery(bag, rosbag::TopicQuery(topic));
    next_ = view_->begin();
    pop();
  }

  /// nullptr after the last one.
  const Message* front() const { return message_.get(); }

  void pop() {
    message_.reset();
    if (next_ == view_->end()) return;
    message_ = next_->template instantiate<Message>();
    if (!message_) {
      throw BagError(topic_ + " is of the type " + next_->getDataType() +
                     ", or of a version of it that this program does not know");
    }
    ++next_;
  }

 private:
  std::string topic_;
  std::unique_ptr<rosbag::View> view_;
  rosbag::View::iterator next_;
  boost::shared_ptr<Message> message_;
};

}  // namespace mass_spring
