// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Haply/HaplyMessages.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace devicebridge
{
namespace
{
using Json = nlohmann::json;

const char* const kKinds[] = {"inverse3", "inverse3x", "minverse"};
const char* const kGrips[] = {"wireless_verse_grip", "verse_grip", "custom_verse_grip"};

/// The vector of a member that exists and has numbers x, y, z.
std::optional<ist::Vec3> vectorOf(const Json& object, const char* name)
{
	const auto found = object.find(name);
	if (found == object.end() || !found->is_object()) return std::nullopt;
	double v[3];
	const char* const names[] = {"x", "y", "z"};
	for (int i = 0; i < 3; ++i)
	{
		const auto number = found->find(names[i]);
		if (number == found->end() || !number->is_number()) return std::nullopt;
		v[i] = number->get<double>();
	}
	return ist::Vec3{v[0], v[1], v[2]};
}

void readGrip(const Json& grip, const std::string& wanted, HaplyState& state)
{
	if (!grip.is_object()) return;
	const auto name = grip.find("device_id");
	const std::string id = name != grip.end() && name->is_string() ? name->get<std::string>() : std::string();
	if (!wanted.empty() && id != wanted) return;
	const auto members = grip.find("state");
	if (members == grip.end() || !members->is_object()) return;
	const std::optional<ist::Vec3> v = vectorOf(*members, "orientation");
	if (v && (*members)["orientation"].contains("w") && (*members)["orientation"]["w"].is_number())
	{
		const double w = (*members)["orientation"]["w"].get<double>(), length = std::sqrt(dot(*v, *v) + w * w);
		if (length > 0.5 && length < 2)
			state.orientation = ist::Quaternion{v->x / length, v->y / length, v->z / length, w / length}, state.gripId = id;
	}
	const auto buttons = members->find("buttons");
	if (buttons == members->end() || !buttons->is_object()) return;
	const char* const names[] = {"a", "b", "c"};
	for (unsigned i = 0; i < 3; ++i)
		if (buttons->contains(names[i]) && (*buttons)[names[i]] == true) state.buttons |= 1U << i;
}

/// The devices of one kind: an array, empty if there is none.
const Json& listOf(const Json& message, const char* kind)
{
	static const Json kNone = Json::array();
	const auto found = message.find(kind);
	return found != message.end() && found->is_array() ? *found : kNone;
}

std::optional<HaplyState> readDevice(const Json& device, const char* kind, const std::string& wanted)
{
	if (!device.is_object() || !device.contains("device_id") || !device["device_id"].is_string()) return std::nullopt;
	HaplyState state;
	state.kind = kind;
	state.deviceId = device["device_id"].get<std::string>();
	if (!wanted.empty() && state.deviceId != wanted) return std::nullopt;
	const auto members = device.find("state");
	if (members == device.end() || !members->is_object()) return std::nullopt;
	const std::optional<ist::Vec3> position = vectorOf(*members, "cursor_position");
	if (!position) return std::nullopt;
	state.position = *position;
	state.velocity = vectorOf(*members, "cursor_velocity").value_or(ist::Vec3{});
	return state;
}
}  // namespace

ist::Result<std::optional<HaplyState>> readHaplyMessage(const std::string& text, const std::string& wanted, const std::string& grip)
{
	const Json message = Json::parse(text, nullptr, false);
	if (message.is_discarded() || !message.is_object()) return ist::Error{"what the service sends is no JSON object", false};
	std::optional<HaplyState> state;
	for (const char* kind : kKinds)
		for (const Json& device : listOf(message, kind))
			if (!state) state = readDevice(device, kind, wanted);
	if (!state) return state;
	for (const char* kind : kGrips)
		for (const Json& candidate : listOf(message, kind))
			if (!state->orientation) readGrip(candidate, grip, *state);
	return state;
}

std::string haplyForceMessage(const std::string& kind, const std::string& deviceId, const ist::Vec3& force, bool valuesForVector)
{
	const Json vector = {{"x", force.x}, {"y", force.y}, {"z", force.z}};
	const Json device = {{"device_id", deviceId}, {"commands", {{"set_cursor_force", {{valuesForVector ? "values" : "vector", vector}}}}}};
	return Json{{kind, Json::array({device})}}.dump();
}
}  // namespace devicebridge
