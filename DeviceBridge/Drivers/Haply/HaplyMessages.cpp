// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Haply/HaplyMessages.h"

#include <cmath>

#include "BulletISTCollision/Json/JsonValue.h"

namespace devicebridge
{
namespace
{
using Json = ist::JsonValue;

const char* const kKinds[] = {"inverse3", "inverse3x", "minverse"};
const char* const kGrips[] = {"wireless_verse_grip", "verse_grip", "custom_verse_grip"};

/// The vector of a member that exists and has numbers x, y, z.
std::optional<ist::Vec3> vectorOf(const Json& object, const char* name)
{
	const Json& found = object[name];
	double v[3];
	const char* const names[] = {"x", "y", "z"};
	for (int i = 0; i < 3; ++i)
	{
		const Json& number = found[names[i]];
		if (!number.isNumber()) return std::nullopt;
		v[i] = number.number();
	}
	return ist::Vec3{v[0], v[1], v[2]};
}

void readGrip(const Json& grip, const std::string& wanted, HaplyState& state)
{
	const std::string& id = grip["device_id"].text();
	if (!wanted.empty() && id != wanted) return;
	const Json &members = grip["state"], &scalar = members["orientation"]["w"];
	const std::optional<ist::Vec3> v = vectorOf(members, "orientation");
	if (v && scalar.isNumber())
	{
		const double w = scalar.number(), length = std::sqrt(dot(*v, *v) + w * w);
		if (length > 0.5 && length < 2)
			state.orientation = ist::Quaternion{v->x / length, v->y / length, v->z / length, w / length}, state.gripId = id;
	}
	const char* const names[] = {"a", "b", "c"};
	for (unsigned i = 0; i < 3; ++i)
		if (members["buttons"][names[i]].flag()) state.buttons |= 1U << i;
}

std::optional<HaplyState> readDevice(const Json& device, const char* kind, const std::string& wanted)
{
	if (!device["device_id"].isText()) return std::nullopt;
	HaplyState state;
	state.kind = kind;
	state.deviceId = device["device_id"].text();
	if (!wanted.empty() && state.deviceId != wanted) return std::nullopt;
	const std::optional<ist::Vec3> position = vectorOf(device["state"], "cursor_position");
	if (!position) return std::nullopt;
	state.position = *position;
	state.velocity = vectorOf(device["state"], "cursor_velocity").value_or(ist::Vec3{});
	return state;
}
}  // namespace

ist::Result<std::optional<HaplyState>> readHaplyMessage(const std::string& text, const std::string& wanted, const std::string& grip)
{
	const Json message = ist::parseJson(text).value;
	if (!message.isObject()) return ist::Error{"what the service sends is no JSON object", false};
	std::optional<HaplyState> state;
	for (const char* kind : kKinds)
		for (const Json& device : message[kind])
			if (!state) state = readDevice(device, kind, wanted);
	if (!state) return state;
	for (const char* kind : kGrips)
		for (const Json& candidate : message[kind])
			if (!state->orientation) readGrip(candidate, grip, *state);
	return state;
}

std::string haplyForceMessage(const std::string& kind, const std::string& deviceId, const ist::Vec3& force, bool valuesForVector)
{
	const Json vector = {{"x", force.x}, {"y", force.y}, {"z", force.z}};
	const Json device = {{"commands", {{"set_cursor_force", {{valuesForVector ? "values" : "vector", vector}}}}}, {"device_id", deviceId}};
	return Json{{kind, Json::list({device})}}.dump();
}
}  // namespace devicebridge
