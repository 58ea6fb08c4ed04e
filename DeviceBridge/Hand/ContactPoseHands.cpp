// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/ContactPoseHands.h"

#include "BulletISTCollision/Core/Platform/MappedFile.h"
#include "BulletISTCollision/Json/JsonValue.h"
#include "DeviceBridge/Hand/HandFromPoints.h"

using namespace ist;

namespace devicebridge
{
namespace
{
using Json = ist::JsonValue;

Result<HandState> readHand(const Json& hand, bool left, const std::string& path)
{
	const Json& joints = hand["joints"];
	if (!joints.isList() || joints.size() != kHandPoints)
		return Error{path + ".joints: must be a list of " + std::to_string(kHandPoints) + " points"};
	HandPoints points;
	for (size_t i = 0; i < kHandPoints; ++i)
	{
		const Json& p = joints[i];
		const bool good = p.isList() && p.size() == 3 && p[0].isNumber() && p[1].isNumber() && p[2].isNumber();
		if (!good) return Error{path + ".joints[" + std::to_string(i) + "]: must be three numbers"};
		points[i] = {p[0].number(), p[1].number(), p[2].number()};
	}
	Result<HandState> made = handFromPoints(points, left);
	if (!made) return Error{path + ".joints: " + made.error().message};
	return made;
}
}  // namespace

Result<ContactPoseHands> readContactPose(const std::string& text, const std::string& name)
{
	const ParsedJson parsed = parseJson(text);
	if (!parsed.ok()) return Error{name + ": is no JSON: " + parsed.problem};
	const Json& hands = parsed.value["hands"];
	if (!hands.isList() || hands.size() != 2) return Error{name + ": hands: must be a list of two, left and right"};
	ContactPoseHands out;
	for (size_t i = 0; i < 2; ++i)
	{
		const Json& hand = hands[i];
		const std::string path = name + ": hands[" + std::to_string(i) + "]";
		if (!hand.contains("valid")) return Error{path + ".valid: is missing"};
		if (!hand["valid"].flag()) continue;
		Result<HandState> made = readHand(hand, i == 0, path);
		if (!made) return made.error();
		(i == 0 ? out.left : out.right) = made.value();
		(i == 0 ? out.leftMoving : out.rightMoving) = hand["moving"].flag();
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
