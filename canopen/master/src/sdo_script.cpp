#include "driveline/canopen_master/sdo_script.hpp"

#include <algorithm>

namespace driveline::canopen {
namespace {

using std::chrono::nanoseconds;

/// How long after a request of another client an answer may be the one to it.
constexpr nanoseconds kForeignTransfer = std::chrono::seconds{1};

}  // namespace

void SdoScript::add(Step step) {
  (collecting_ ? added_ : steps_).push_back(std::move(step));
}

void SdoScript::clear() {
  steps_.clear();
  added_.clear();
  if (transfer_ && !asked_) then_ = {};
}

void SdoScript::ask(SdoObject object, std::optional<std::vector<std::byte>> data, Then then) {
  requests_.push_back({object, std::move(data), std::move(then), {}});
}

void SdoScript::forget_node() {
  const auto error = [this](SdoObject object) {
    ClientError lost{ClientErrorKind::kNoAnswer, node_, object, SdoAbort::kTimeout};
    lost.waited = options_.answer_timeout;
    return lost;
  };
  forgotten_until_ = std::max({forgotten_until_, old_answer_until_, transfer_ ? answer_until_ : nanoseconds{0}});
  old_answer_until_ = nanoseconds{0};
  if (!transfer_) return;
  transfer_.reset();
  const auto then = std::exchange(then_, {});
  if (!then) return;
  ClientResult<std::vector<std::byte>> result = tl::unexpected(error(object_));
  collect([&] { then(result); });
}

std::optional<Frame> SdoScript::outgoing() const {
  if (!transfer_ || !transfer_->outgoing()) return std::nullopt;
  return Frame::of(options_.request.value + node_, *transfer_->outgoing());
}

void SdoScript::sent(nanoseconds now) {
  if (!transfer_) return;
  answer_until_ = now + options_.answer_timeout;
  transfer_->sent(now);
  finish(now);
}

void SdoScript::fail(const ClientError& error) {
  if (!transfer_) return;
  transfer_->fail(error);
  finish(nanoseconds{0});
}

bool SdoScript::expected(const Frame& frame) const noexcept {
  if (!transfer_ || transfer_->outgoing()) return false;
  const auto message = SdoMessage::decode(frame.payload());
  if (!message) return true;
  // The second answer to the last request comes while the next one is under way.
  const bool initiate = message->specifier() == static_cast<std::uint8_t>(SdoResponse::kInitiateUpload) ||
                        message->specifier() == static_cast<std::uint8_t>(SdoResponse::kInitiateDownload);
  const SdoObject about{message->index, message->subindex};
  return !initiate || about == object_ || about != last_;
}

bool SdoScript::receive(const Frame& frame, nanoseconds time) {
  if (frame.kind != FrameKind::kData || frame.identifier.extended) return false;
  if (frame.identifier.value == options_.request.value + node_) {
    foreign_request_until_ = time + kForeignTransfer;
    return false;
  }
  if (frame.identifier.value != options_.answer.value + node_) return false;
  const auto excused_until = std::max({old_answer_until_, forgotten_until_, foreign_request_until_});
  if (!expected(frame) && time >= excused_until) ++unasked_;
  if (!transfer_) {
    old_answer_until_ = nanoseconds{0};
    return true;
  }
  transfer_->receive(frame.payload());
  finish(time);
  return true;
}

void SdoScript::advance(nanoseconds now) {
  if (transfer_) {
    transfer_->advance(now);
    finish(now);
  }
  begin(now);
}

void SdoScript::begin(nanoseconds now) {
  while (!transfer_ && now >= old_answer_until_) {
    const bool asked = !requests_.empty();
    auto& queue = asked ? requests_ : steps_;
    if (queue.empty()) return;
    auto step = std::move(queue.front());
    queue.pop_front();
    if (step.call) {
      collect(step.call);
    } else {
      begin(std::move(step), asked);
    }
  }
}

void SdoScript::begin(Step step, bool asked) {
  last_ = std::exchange(object_, step.object);
  then_ = std::move(step.then);
  asked_ = asked;
  transfer_ = step.data ? SdoTransfer::download(node_, step.object, *step.data, options_)
                        : SdoTransfer::upload(node_, step.object, options_);
}

void SdoScript::finish(nanoseconds now) {
  if (!transfer_ || !transfer_->done()) return;
  const auto ended = std::move(transfer_);
  const auto then = std::exchange(then_, {});
  if (ended->abandoned()) old_answer_until_ = now + options_.answer_timeout;
  if (then) collect([&] { then(ended->result()); });
  begin(now);
}

void SdoScript::collect(const std::function<void()>& run) {
  collecting_ = true;
  run();
  collecting_ = false;
  steps_.insert(steps_.begin(), std::make_move_iterator(added_.begin()), std::make_move_iterator(added_.end()));
  added_.clear();
}

}  // namespace driveline::canopen
