// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/Grasp/HeatMapTexture.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"
#include "tests/unit/DeviceBridge/Hand/GridBox.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>
#include <random>

using namespace devicebridge;
using ist::Pose;
using ist::TexturedMesh;
using ist::Vec3;

namespace
{
constexpr double kK = 5e7, kDepth = 0.0004, kWidth = 0.008, kSeconds = 0.5;  // Pa/m, m, m, s
constexpr double kForce = kK * kWidth * kWidth * kDepth;
const Vec3 kHalf{0.01, 0.005, 0.01};

/// A slab that lies, rotated, on the upper side of a box: kDepth deep everywhere.
struct SlabOnBox
{
	HeatMap map;
	Pose X;

	explicit SlabOnBox(ist::Mesh box)
		: map(std::move(box)),
		  X{rotationMatrix(ist::quaternionFromRotationVector({0, 0.4, 0})), {0.001, 0.015 - kDepth, 0.0013}}
	{
		map.addPart("R_Index3", 43, ist::makeBoxMesh({kWidth / 2, 0.01, kWidth / 2}));
		map.add(0, {X, kForce, {0, 0.005, 0}, kSeconds});
	}
};

double sum(const HeatMapTexture& texture, const std::vector<double>& values)
{
	return std::inner_product(values.begin(), values.end(), texture.areas().begin(), 0.0);
}

/// Value of the picture at a place, linear between the centres of four texels.
double bilinear(const HeatMapTexture& t, const std::vector<double>& values, const ist::TexturePlace& place)
{
	const double x = place.u * t.width() - 0.5, y = (1 - place.v) * t.height() - 0.5;
	const int i = int(std::floor(x)), j = int(std::floor(y));
	const auto at = [&](int dx, int dy) { return values[size_t((j + dy) * t.width() + i + dx)]; };
	const double u = x - i, v = y - j;
	return (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
}

std::string refusal(const ist::Mesh& object, const TexturedMesh& surface, const HeatMapTextureOptions& options = {})
{
	const auto made = HeatMapTexture::make(object, surface, options);
	EXPECT_FALSE(made);
	return made ? std::string() : made.error().message;
}
}  // namespace

// Closed form: the pressure is k d inside the slab and zero outside, the impulse per area is k d t. The sum over all texels is the whole
// impulse.
TEST(HeatMapTexture, SlabOnSlabHasTheClosedFormInEveryTexel)
{
	const TexturedMesh box = texturedGridBox(kHalf, 50);
	const SlabOnBox slab(box.mesh);
	const auto texture = HeatMapTexture::make(slab.map.mesh(), box, {512, 384, 4, 0});
	ASSERT_TRUE(texture) << texture.error().message;
	const std::vector<double> ones(texture.value().areas().size(), 1);
	const double area = 8 * (kHalf.x * kHalf.y + kHalf.y * kHalf.z + kHalf.z * kHalf.x);
	EXPECT_NEAR(sum(texture.value(), ones), area, area / 136);  // each side is 136.5 texels wide
	const std::vector<double> impulse = texture.value().values(slab.map, HeatMapValue::Impulse).value(),
							  pressure = texture.value().values(slab.map, HeatMapValue::Pressure).value();
	EXPECT_NEAR(sum(texture.value(), impulse), kForce * kSeconds, 0.02 * kForce * kSeconds);

	// The upper side of the box is the upper one of the second pair; x points up and z to the right.
	int inside = 0, outside = 0;
	for (int y = 0; y < 384; ++y)
		for (int x = 0; x < 512; ++x)
		{
			const size_t i = size_t(y * 512 + x);
			if (texture.value().areas()[i] == 0) continue;
			const double u = (3 * (x + 0.5) / 512 - 1.1) / 0.8, v = (2 * (1 - (y + 0.5) / 384) - 1.1) / 0.8;
			const Vec3 p = inverse(slab.X) * Vec3{kHalf.x * (2 * v - 1), kHalf.y, kHalf.z * (2 * u - 1)};
			const double rim = std::max(std::fabs(p.x), std::fabs(p.z)) - kWidth / 2, grid = 2 * kHalf.x / 50 * std::sqrt(2.0);
			const bool upper = u > 0 && u < 1 && v > 0 && v < 1;
			if (upper && rim < -2 * grid)
			{
				++inside;
				ASSERT_NEAR(pressure[i], kK * kDepth, 0.03 * kK * kDepth);
				ASSERT_NEAR(impulse[i], kK * kDepth * kSeconds, 0.03 * kK * kDepth * kSeconds);
			}
			else if (!upper || rim > 2 * grid)
			{
				++outside;
				ASSERT_EQ(pressure[i], 0);
			}
		}
	EXPECT_GT(inside, 1000);
	EXPECT_GT(outside, 100000);
}

TEST(HeatMapTexture, TheFilesMeshMayBeAnotherThanTheMapsOwn)
{
	const SlabOnBox slab(gridBox(kHalf, 50));
	// Twelve triangles that share no vertex, as a file reader gives them.
	TexturedMesh coarse = texturedGridBox(kHalf, 1), file;
	for (size_t t = 0; t < coarse.places.size(); ++t)
	{
		file.places.push_back(coarse.places[t]);
		for (const uint32_t corner : coarse.mesh.triangles[t]) file.mesh.vertices.push_back(coarse.mesh.vertices[corner]);
		file.mesh.triangles.push_back({uint32_t(3 * t), uint32_t(3 * t + 1), uint32_t(3 * t + 2)});
	}
	const auto fine = HeatMapTexture::make(slab.map.mesh(), texturedGridBox(kHalf, 50), {300, 200, 2, 0}),
			   other = HeatMapTexture::make(slab.map.mesh(), file, {300, 200, 2, 0});
	ASSERT_TRUE(fine && other);
	const auto a = fine.value().values(slab.map, HeatMapValue::Impulse).value(),
			   b = other.value().values(slab.map, HeatMapValue::Impulse).value();
	for (size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-5 * kK * kDepth * kSeconds);
	EXPECT_NEAR(sum(other.value(), b), kForce * kSeconds, 0.02 * kForce * kSeconds);
	// A surface beside the object was not touched.
	TexturedMesh away = file;
	away.mesh = translated(away.mesh, {0, 0.003, 0});
	const auto bare = HeatMapTexture::make(slab.map.mesh(), away, {300, 200, 2, 1e-3});
	ASSERT_TRUE(bare);
	EXPECT_EQ(sum(bare.value(), bare.value().values(slab.map, HeatMapValue::Impulse).value()), 0);
}

TEST(HeatMapTexture, EveryTexelBelongsToOneTriangleOfASheet)
{
	// Corners lie on texel centres, on texel edges, and anywhere.
	std::mt19937 random(5);
	std::uniform_real_distribution<double> shift(-0.4, 0.4);
	const int n = 8;
	for (const bool crooked : {false, true})
	{
		TexturedMesh sheet;
		for (int j = 0; j <= n; ++j)
			for (int i = 0; i <= n; ++i)
			{
				const bool inner = crooked && i % n && j % n;
				sheet.mesh.vertices.push_back({(i + (inner ? shift(random) : 0)) / n, (j + (inner ? shift(random) : 0)) / n, 0});
			}
		for (uint32_t j = 0; j < n; ++j)
			for (uint32_t i = 0; i < n; ++i)
			{
				const uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
				for (const auto& t : {std::array<uint32_t, 3>{a, b, d}, std::array<uint32_t, 3>{a, d, c}})
				{
					sheet.mesh.triangles.push_back(t);
					std::array<ist::TexturePlace, 3> places;
					for (size_t k = 0; k < 3; ++k) places[k] = {sheet.mesh.vertices[t[k]].x, sheet.mesh.vertices[t[k]].y};
					sheet.places.push_back(places);
				}
			}
		for (const int size : {8, 16, 36})
		{
			// A shift of half a texel puts texel centres on the corners.
			TexturedMesh moved = sheet;
			for (auto& t : moved.places)
				for (auto& place : t) place = {place.u + 0.5 / size, place.v - 0.5 / size};
			for (const TexturedMesh* m : {&sheet, &moved})
			{
				const auto texture = HeatMapTexture::make(m->mesh, *m, {size, size, 0, 0});
				ASSERT_TRUE(texture);
				for (const double area : texture.value().areas()) ASSERT_NEAR(area, 1.0 / (size * size), 1e-12);
			}
		}
	}
}

TEST(HeatMapTexture, ShowsNoSeamBetweenIslands)
{
	// A ball presses on the edge between the upper side (y) and the side at +x.
	const TexturedMesh box = texturedGridBox({0.01, 0.01, 0.01}, 40);
	HeatMap map(box.mesh);
	map.addPart("R_Thumb3", 55, ist::makeSphereMesh(0.005, 4));
	map.add(0, {{{}, {0.012, 0.012, 0.0007}}, 3, {0.01, 0.01, 0}, 1});
	const auto texture = HeatMapTexture::make(map.mesh(), box, {600, 400, 3, 0}),
			   hard = HeatMapTexture::make(map.mesh(), box, {600, 400, 0, 0});
	ASSERT_TRUE(texture && hard);
	const auto values = texture.value().values(map, HeatMapValue::Impulse).value(),
			   cut = hard.value().values(map, HeatMapValue::Impulse).value();
	const std::vector<HeatMap::Vertex> vertices = map.vertices();
	double peak = 0, worst = 0, worstCut = 0;
	for (const double value : values) peak = std::max(peak, value);
	int shared = 0;
	for (uint32_t v = 0; v < vertices.size(); ++v)
	{
		const Vec3& p = box.mesh.vertices[v];
		if (p.x != 0.01 || p.y != 0.01 || std::fabs(p.z) > 0.009) continue;
		++shared;
		double low = 1e300, high = 0, lowCut = 1e300;
		for (size_t t = 0; t < box.places.size(); ++t)
			for (size_t c = 0; c < 3; ++c)
			{
				if (box.mesh.triangles[t][c] != v) continue;
				const double value = bilinear(texture.value(), values, box.places[t][c]);
				low = std::min(low, value), high = std::max(high, value);
				lowCut = std::min(lowCut, bilinear(hard.value(), cut, box.places[t][c]));
			}
		worst = std::max(worst, (high - low) / peak);
		worstCut = std::max(worstCut, (high - lowCut) / peak);
	}
	EXPECT_GT(shared, 30);
	EXPECT_LT(worst, 0.08);
	EXPECT_GT(worstCut, 0.2);  // error without a margin
}

TEST(HeatMapTexture, TexelsOfSeveralPlacesTakeTheirMeanAndLoseNothing)
{
	// All six sides use the same part of the picture, shifted by one picture to the left.
	TexturedMesh box = texturedGridBox(kHalf, 50);
	for (auto& t : box.places)
		for (auto& place : t) place = {std::fmod(3 * place.u, 1.0) - 1, std::fmod(2 * place.v, 1.0)};
	const SlabOnBox slab(box.mesh);
	const auto texture = HeatMapTexture::make(slab.map.mesh(), box, {200, 200, 0, 0});
	ASSERT_TRUE(texture) << texture.error().message;
	const auto values = texture.value().values(slab.map, HeatMapValue::Impulse).value();
	EXPECT_NEAR(sum(texture.value(), values), kForce * kSeconds, 0.02 * kForce * kSeconds);
	EXPECT_LT(*std::max_element(values.begin(), values.end()), 0.5 * kK * kDepth * kSeconds);
}

TEST(HeatMapTexture, PicturesHaveTheFingersColoursAndTheValuesShade)
{
	const TexturedMesh box = texturedGridBox(kHalf, 20);
	const SlabOnBox slab(box.mesh);
	const auto made = HeatMapTexture::make(slab.map.mesh(), box, {120, 80, 2, 0});
	ASSERT_TRUE(made);
	const HeatMapTexture& texture = made.value();
	const Picture fingers = texture.colours(slab.map).value();
	const std::vector<double> pressure = texture.values(slab.map, HeatMapValue::Pressure).value();
	const HeatMapColour blue = handPartColour(43);
	const size_t middle = size_t(20 * 120 + 60), corner = 0;
	EXPECT_EQ(fingers.pixels[3 * middle], blue.r);
	EXPECT_EQ(fingers.pixels[3 * middle + 1], blue.g);
	EXPECT_EQ(fingers.pixels[3 * middle + 2], blue.b);
	EXPECT_EQ(fingers.pixels[3 * corner], heatMapColour(slab.map, {}, HeatMapColours::Fingers).r);
	EXPECT_EQ(texture.colours(slab.map, HeatMapColours::ContactPose).value().pixels[3 * middle], 255);
	const GreyPicture grey = greyPicture(texture, pressure, 2 * kK * kDepth);
	EXPECT_NEAR(grey.pixels[middle], 65535 / 2.0, 0.03 * 65535);
	EXPECT_EQ(grey.pixels[corner], 0);
	EXPECT_EQ(greyPicture(texture, pressure, 0.1 * kK * kDepth).pixels[middle], 65535);
}

TEST(HeatMapTexture, PicturesComeBackFromTheirFiles)
{
	const TexturedMesh box = texturedGridBox(kHalf, 20);
	const SlabOnBox slab(box.mesh);
	const auto made = HeatMapTexture::make(slab.map.mesh(), box, {120, 80, 2, 0});
	ASSERT_TRUE(made);
	const Picture fingers = made.value().colours(slab.map).value();
	const GreyPicture grey = greyPicture(made.value(), made.value().values(slab.map, HeatMapValue::Pressure).value(), 2 * kK * kDepth);

	const std::string path =
		(std::filesystem::temp_directory_path() / ("texture" + std::to_string(std::random_device()()) + ".png")).string();
	const auto failed = savePicture(fingers, path);
	if (failed && failed->message.find("install libpng-dev") != std::string::npos) GTEST_SKIP() << failed->message;
	ASSERT_FALSE(failed) << failed->message;
	const auto read = loadPicture(path);
	ASSERT_TRUE(read) << read.error().message;
	EXPECT_EQ(read.value().pixels, fingers.pixels);
	ASSERT_FALSE(savePicture(grey, path));
	const auto readGrey = loadGreyPicture(path);
	ASSERT_TRUE(readGrey) << readGrey.error().message;
	EXPECT_EQ(readGrey.value().width, 120);
	EXPECT_EQ(readGrey.value().pixels, grey.pixels);
	std::filesystem::remove(path);
}

TEST(HeatMapTexture, RefusesTheMapOfAnotherObject)
{
	const TexturedMesh box = texturedGridBox(kHalf, 20);
	const auto texture = HeatMapTexture::make(box.mesh, box, {120, 80, 2, 0});
	ASSERT_TRUE(texture);
	EXPECT_TRUE(texture.value().values(SlabOnBox(box.mesh).map, HeatMapValue::Dwell));
	// Meshes that differ: fewer vertices; as many vertices but one displaced; the same vertices in triangles that face inward.
	ist::Mesh moved = box.mesh, turned = box.mesh;
	moved.vertices[7].x += 1e-9;
	for (auto& t : turned.triangles) std::swap(t[0], t[1]);
	for (const ist::Mesh& mesh : {gridBox(kHalf, 10), moved, turned})
	{
		const SlabOnBox other(mesh);
		const auto values = texture.value().values(other.map, HeatMapValue::Dwell);
		const auto colours = texture.value().colours(other.map);
		ASSERT_FALSE(values || colours);
		EXPECT_NE(values.error().message.find("another object"), std::string::npos);
		EXPECT_EQ(values.error().message, colours.error().message);
	}
}

TEST(HeatMapTexture, RefusesInASentence)
{
	const TexturedMesh box = texturedGridBox(kHalf, 4);
	EXPECT_NE(refusal(box.mesh, {box.mesh, {}}).find("no texture coordinates"), std::string::npos);
	EXPECT_NE(refusal({}, box).find("no surface"), std::string::npos);
	EXPECT_NE(refusal(box.mesh, box, {0, 100, 4, 0}).find("1 to 16384"), std::string::npos);
	EXPECT_NE(refusal(box.mesh, box, {100, 100, -1, 0}).find("negative"), std::string::npos);
	// Each side is within its bounds, but the picture is not.
	EXPECT_NE(refusal(box.mesh, box, {8193, 8192, 4, 0}).find("8193 by 8192"), std::string::npos);
	EXPECT_NE(refusal(box.mesh, box, {16384, 16384, 4, 0}).find("too large"), std::string::npos);
	TexturedMesh bad = box;
	bad.places[3][1].u = std::numeric_limits<double>::quiet_NaN();
	EXPECT_NE(refusal(box.mesh, bad).find("not finite"), std::string::npos);
	bad = box;
	for (auto& t : bad.places)
		for (auto& place : t) place.u += 1e9;
	EXPECT_NE(refusal(box.mesh, bad).find("a million"), std::string::npos);
	bad = box;
	for (auto& t : bad.places)
		for (auto& place : t) place = {20 * place.u, 20 * place.v};
	EXPECT_NE(refusal(box.mesh, bad).find("repeats"), std::string::npos);
	// The texture covers the picture seven times, which is too much only for a picture of that size.
	bad = box;
	for (auto& t : bad.places)
		for (auto& place : t) place = {7 * place.u, place.v};
	EXPECT_NE(refusal(box.mesh, bad, {8192, 8192, 4, 0}).find("smaller picture"), std::string::npos);
	EXPECT_TRUE(HeatMapTexture::make(box.mesh, bad, {64, 64, 4, 0}));
	bad = box;
	for (auto& t : bad.places)
		for (auto& place : t) place = {1e-6 * place.u, 1e-6 * place.v};
	EXPECT_NE(refusal(box.mesh, bad).find("no texel"), std::string::npos);
}
