// SPDX-License-Identifier: Zlib
// Scene files: any text is refused with the file's name, or gives a valid scene.
#include "TestSupport/SceneFiles/SceneFile.h"

#include "tests/fuzz/Invariants.h"

using fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
	const ist::Result<scenes::Scene> scene = scenes::parseScene("a.json", fuzz::text(data, size), "/nowhere");
	if (!fuzz::accepted(scene))
	{
		require(scene.error().message.starts_with("a.json"), "a refusal names the file");
		return 0;
	}
	const scenes::Scene& s = scene.value();
	for (const scenes::SceneBody& body : s.bodies)
	{
		require(body.kind != scenes::SceneBody::Kind::Asset || body.asset < s.assets.size(), "a body's asset is there");
		require(std::isfinite(body.mass) && body.mass >= 0, "a mass is none or positive");
	}
	for (const auto& [a, b] : s.pairs) require(a < s.bodies.size() && b < s.bodies.size(), "pairs are of bodies");
	for (const scenes::SceneHand& hand : s.hands)
	{
		require(hand.parts || hand.tool < s.bodies.size(), "the tool is a body");
		for (size_t i = 1; i < hand.path.size(); ++i) require(hand.path[i - 1].time < hand.path[i].time, "times of the path grow");
	}
	require(std::isfinite(s.worldRate) && s.worldRate > 0, "a rate is positive");
	return 0;
}
