// SPDX-License-Identifier: Zlib
#include "demos/scenes/Grasp/GraspObjects.h"

#include <gtest/gtest.h>

#include <random>

using namespace scenes;
using ist::TexturePlace;

namespace
{
double twice(const TexturePlace& a, const TexturePlace& b, const TexturePlace& c)
{
	return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
}

bool holds(const std::array<TexturePlace, 3>& t, const TexturePlace& p)
{
	const double a = twice(t[0], t[1], p), b = twice(t[1], t[2], p), c = twice(t[2], t[0], p);
	return (a > 0 && b > 0 && c > 0) || (a < 0 && b < 0 && c < 0);
}
}  // namespace

class UnwrapTest : public testing::TestWithParam<const char*>
{};

TEST_P(UnwrapTest, EveryPlaceOfTheSurfaceHasItsOwnInThePicture)
{
	const GraspObject object = makeGraspObject(GetParam()).value();
	ASSERT_EQ(object.texture.places.size(), object.mesh.triangles.size());
	for (const auto& t : object.texture.places)
		for (const TexturePlace& place : t) ASSERT_TRUE(place.u >= 0 && place.u <= 1 && place.v >= 0 && place.v <= 1);
	std::mt19937 random(6);
	int alone = 0, widest = 0;
	constexpr int kSamples = 400;
	for (int i = 0; i < kSamples; ++i)
	{
		const auto& t = object.texture.places[random() % object.texture.places.size()];
		const TexturePlace middle{(t[0].u + t[1].u + t[2].u) / 3, (t[0].v + t[1].v + t[2].v) / 3};
		int here = 0;
		for (const auto& other : object.texture.places) here += holds(other, middle);
		alone += here == 1;
		// A triangle that crosses the picture would show everything.
		for (size_t c = 0; c < 3; ++c) widest += std::hypot(t[c].u - t[(c + 1) % 3].u, t[c].v - t[(c + 1) % 3].v) > 0.05;
	}
	EXPECT_GT(alone, 0.98 * kSamples);
	EXPECT_EQ(widest, 0);
}
INSTANTIATE_TEST_SUITE_P(Objects, UnwrapTest, testing::Values("mug", "ring"));
