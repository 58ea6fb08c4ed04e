// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/ContactPoseHands.h"

#include "BulletISTCollision/Core/Asset/AtomicFile.h"
#include "DeviceBridge/Hand/HandFromPoints.h"

#include <nlohmann/json.hpp>

using namespace ist;

namespace devicebridge
{
namespace
{
using Json = nlohmann::json;

Result<HandState> readHand(const Json& hand, bool left, const std::string& path)
{
	const auto joints = hand.find("joints");
	if (joints == hand.end() || !joints->is_array() || joints->size() != kHandPoints)
		return Error{path + ".joints: must be a list of " + std::to_string(kHandPoints) + " points"};
	HandPoints points;
	for (size_t i = 0; i < kHandPoints; ++i)
	{
		const Json& p = (*joints)[i];
		const bool good = p.is_array() && p.size() == 3 && p[0].is_number() && p[1].is_number() && p[2].is_number();
		if (!good) return Error{path + ".joints[" + std::to_string(i) + "]: must be three numbers"};
		points[i] = {p[0].get<double>(), p[1].get<double>(), p[2].get<double>()};
	}
	Result<HandState> made = handFromPoints(points, left);
	if (!made) return Error{path + ".joints: " + made.error().message};
	return made;
}

bool flag(const Json& hand, const char* name)
{
	const auto found = hand.find(name);
	return found != hand.end() && found->is_boolean() && found->get<bool>();
}
}  // namespace

Result<ContactPoseHands> readContactPose(const std::string& text, const std::string& name)
{
	Json json;
	try
	{
		json = Json::parse(text);
	}
	catch (const Json::exception& e)
	{
		return Error{name + ": is no JSON: " + e.what()};
	}
	const auto hands = json.is_object() ? json.find("hands") : json.end();
	if (!json.is_object() || hands == json.end() || !hands->is_array() || hands->size() != 2)
		return Error{name + ": hands: must be a list of two, left and right"};
	ContactPoseHands out;
	for (size_t i = 0; i < 2; ++i)
	{
		const Json& hand = (*hands)[i];
		const std::string path = name + ": hands[" + std::to_string(i) + "]";
		if (!hand.is_object() || !hand.contains("valid")) return Error{path + ".valid: is missing"};
		if (!flag(hand, "valid")) continue;
		Result<HandState> made = readHand(hand, i == 0, path);
		if (!made) return made.error();
		(i == 0 ? out.left : out.right) = made.value();
		(i == 0 ? out.leftMoving : out.rightMoving) = flag(hand, "moving");
	}
	return out;
}

Result<ContactPoseHands> loadContactPose(const std::string& path)
{
	const Result<MappedFile> file = MappedFile::open(path);
	if (!file) return file.error();
	return readContactPose(std::string(reinterpret_cast<const char*>(file.value().bytes()), file.value().size()), path);
}
}  // namespace devicebridge
