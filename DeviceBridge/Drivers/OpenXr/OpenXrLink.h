// SPDX-License-Identifier: Zlib
#pragma once

#include <memory>
#include <string>

#include "DeviceBridge/Device/DeviceLink.h"

namespace devicebridge
{
class OpenXrSession;

/// One hand as an OpenXR runtime tracks it: the joints with their radii; the handle is the palm. W is the runtime's local space: x to the
/// right, y up, z towards the user. It exerts no force. While the runtime does not see the hand, kHandPresent is not set.
class OpenXrLink final : public DeviceLink
{
public:
	OpenXrLink(bool left, std::string uri);
	~OpenXrLink() override;

	ist::Result<DeviceInfo> connect() noexcept override;
	Event exchange(const DeviceCommand& command, DeviceSample& sample) noexcept override;
	void disconnect() noexcept override;
	std::string complaint() const override { return m_complaint; }

private:
	struct Tracker;
	Event lost(const std::string& why);

	bool m_left;
	std::string m_uri, m_complaint;
	std::shared_ptr<OpenXrSession> m_session;
	std::unique_ptr<Tracker> m_tracker;
	ist::Pose m_lastPalm;
	std::int64_t m_next = 0;
};

/// Why `openxr:` can open no hand; empty if a runtime answers.
std::string openXrMissing();
}  // namespace devicebridge
