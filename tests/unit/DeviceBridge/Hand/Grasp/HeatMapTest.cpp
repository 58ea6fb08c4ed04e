// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "DeviceBridge/Hand/Grasp/HeatMapFile.h"
#include "tests/unit/CountingAllocator.h"
#include "tests/unit/DeviceBridge/Hand/GridBox.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <sstream>

using namespace devicebridge;
using ist::Mesh;
using ist::Pose;
using ist::Vec3;

namespace
{
constexpr double kPi = 3.14159265358979323846;
constexpr double kK = 5e7;  // stiffness of the pair [Pa/m]

Pose randomPose(unsigned seed)
{
	std::mt19937 random(seed);
	std::uniform_real_distribution<double> any(-1, 1);
	return {rotationMatrix(ist::quaternionFromRotationVector({2 * any(random), 2 * any(random), any(random)})),
		{any(random), any(random), any(random)}};
}

/// Total force according to the map: each vertex's impulse along the mean of the normals around it.
Vec3 forceOf(const HeatMap& map, double seconds)
{
	const Mesh& mesh = map.mesh();
	std::vector<Vec3> normals(mesh.vertices.size());
	for (const auto& t : mesh.triangles)
		for (const uint32_t c : t)
			normals[c] += cross(mesh.vertices[t[1]] - mesh.vertices[t[0]], mesh.vertices[t[2]] - mesh.vertices[t[0]]);
	const std::vector<HeatMap::Vertex> values = map.vertices();
	Vec3 sum;
	for (size_t v = 0; v < values.size(); ++v) sum = sum - values[v].impulse / seconds * normalized(normals[v]);
	return sum;
}
}  // namespace

// Closed form: area pi (2 R d - d^2), force k V with V = pi d^2 (3 R - d) / 3, pressure k d in the middle.
TEST(HeatMap, BallOnAHalfSpaceHasTheAreaAndPressureOfTheClosedForm)
{
	const double R = 0.01, half = 0.006;
	for (const double d : {0.0003, 0.0006})
	{
		const double area = kPi * (2 * R * d - d * d), force = kK * kPi * d * d * (3 * R - d) / 3;
		HeatMap map(gridBox({half, half, half}, 60));
		const Mesh ball = transformed(ist::makeSphereMesh(R, 5), randomPose(1));
		const int part = map.addPart("ball", 45, ball);
		const Pose X{{}, {0.0003, half + R - d, -0.0002}};
		const HeatMapTouch touch = map.add(part, {X * inverse(randomPose(1)), force, {0, half, 0}, 0.01});
		EXPECT_NEAR(touch.area, area, 0.02 * area) << d;
		EXPECT_NEAR(kK * touch.depthSum, force, 0.02 * force) << d;
		EXPECT_NEAR(touch.pressure, kK * d, 0.02 * kK * d) << d;
		EXPECT_NEAR(touch.depth, d, 0.02 * d);
		const HeatMap::Summary row = map.summary()[0];
		EXPECT_EQ(row.grasps, 1);
		EXPECT_NEAR(row.peakForce, force, 1e-12);
		EXPECT_NEAR(norm(forceOf(map, 0.01) - Vec3{0, -force, 0}), 0, 0.02 * force);
	}
}

// The depth is the same over the whole area: pressure k d, force k A d.
TEST(HeatMap, SlabOnSlabHasEvenPressure)
{
	const double d = 0.0004, width = 0.008, force = kK * width * width * d;
	HeatMap map(gridBox({0.01, 0.005, 0.01}, 50));
	const int part = map.addPart("slab", 1, ist::makeBoxMesh({width / 2, 0.01, width / 2}));
	const Pose X{rotationMatrix(ist::quaternionFromRotationVector({0, 0.4, 0})), {0.001, 0.015 - d, 0.0013}};
	const HeatMapTouch touch = map.add(part, {X, force, {0, 0.005, 0}, 0.5});
	EXPECT_NEAR(touch.area, width * width, 0.02 * width * width);
	EXPECT_NEAR(kK * touch.depthSum, force, 0.02 * force);
	EXPECT_NEAR(touch.pressure, kK * d, 0.02 * kK * d);
	EXPECT_NEAR(norm(forceOf(map, 0.5) - Vec3{0, -force, 0}), 0, 0.02 * force);
	int even = 0, inside = 0;
	for (const HeatMap::Vertex& v : map.vertices())
	{
		if (v.part < 0) continue;
		++inside;
		even += std::fabs(v.pressure / (kK * d) - 1) < 0.03;
		EXPECT_NEAR(v.dwell, 0.5, 1e-6);
		EXPECT_EQ(v.contact, 1);
	}
	EXPECT_GT(inside, 300);
	EXPECT_GT(even, 0.8 * inside);  // the other vertices are at the rim, where triangles are cut
}

TEST(HeatMap, ForceOnACurvedBodyIsTheContactsAndStaysWithinIt)
{
	const Pose X_WO = randomPose(7);
	HeatMap map(transformed(ist::makeSphereMesh(0.03, 6), X_WO));
	const int part = map.addPart("finger", 41, ist::makeCapsuleMesh(0.008, 0.012, 48));
	std::mt19937 random(2);
	std::normal_distribution<double> gauss;
	for (int i = 0; i < 10; ++i)
	{
		HeatMap one(map.mesh());
		one.addPart("finger", 41, ist::makeCapsuleMesh(0.008, 0.012, 48));
		const Vec3 out = normalized(Vec3{gauss(random), gauss(random), gauss(random)});
		// The side of the capsule is tilted and half a millimetre deep.
		Vec3 t1, t2;
		completeFrame(out, t1, t2);
		const Pose X{{{{t1.x, out.x, -t2.x}, {t1.y, out.y, -t2.y}, {t1.z, out.z, -t2.z}}}, 0.0375 * out};
		ASSERT_TRUE(isRigid(X));
		const Vec3 force = X_WO.rotation * (-3.0 * out);
		const HeatMapTouch touch = one.add(part, {X_WO * X, norm(force), X_WO * (0.03 * out), 0.002});
		EXPECT_GT(touch.area, 1e-5);
		EXPECT_NEAR(norm(forceOf(one, 0.002) - force), 0, 0.02 * norm(force));
		const auto values = one.vertices(part);
		double furthest = 0;
		for (size_t v = 0; v < values.size(); ++v)
			if (values[v].part >= 0) furthest = std::max(furthest, distance(one.mesh().vertices[v], X_WO * (0.03 * out)));
		EXPECT_LT(furthest, 0.015);
	}
}

TEST(HeatMap, ContactBetweenTheVerticesGoesToTheNearestOne)
{
	HeatMap map(ist::makeBoxMesh({0.1, 0.1, 0.1}));
	const int part = map.addPart("tip", 43, ist::makeSphereMesh(0.005, 3));
	const HeatMapTouch touch = map.add(part, {{{}, {0.09, 0.1045, 0.08}}, 2, {0.09, 0.1, 0.08}, 0.1});
	EXPECT_EQ(touch.area, 0);
	// The area of a corner vertex is a third of each triangle there.
	double area = 0;
	for (const auto& t : map.mesh().triangles)
		for (const uint32_t c : t) area += map.mesh().vertices[c] == Vec3{0.1, 0.1, 0.1} ? 0.2 * 0.2 / 2 / 3 : 0;
	EXPECT_NEAR(touch.pressure, 2 / area, 1e-9 / area);
	const auto values = map.vertices();
	for (size_t v = 0; v < values.size(); ++v)
	{
		const bool nearest = map.mesh().vertices[v] == Vec3{0.1, 0.1, 0.1};
		EXPECT_EQ(values[v].part, nearest ? 0 : -1);
		EXPECT_NEAR(values[v].impulse, nearest ? 0.2 : 0, 1e-12);
		EXPECT_NEAR(values[v].peak, nearest ? 2 / area : 0, 1e-6 / area);
	}
}

TEST(HeatMap, GraspsAddUp)
{
	HeatMap map(gridBox({0.01, 0.01, 0.01}, 20));
	const int a = map.addPart("R_Index3", 43, ist::makeSphereMesh(0.005, 3)),
			  b = map.addPart("R_Thumb3", 55, ist::makeSphereMesh(0.005, 3));
	const Pose above{{}, {0, 0.0145, 0}}, below{{}, {0, -0.0145, 0}};
	for (int grasp = 0; grasp < 4; ++grasp)
	{
		if (grasp > 0) map.beginGrasp();
		map.add(a, {above, 1, {0, 0.01, 0}, 0.1});
		if (grasp == 2) map.add(b, {below, 4, {0, -0.01, 0}, 0.3});
		if (grasp == 2) map.add(b, {below, 2, {0, -0.01, 0}, 0.1});
	}
	EXPECT_EQ(map.grasps(), 4);
	const auto rows = map.summary();
	EXPECT_EQ(rows[size_t(a)].grasps, 4);
	EXPECT_EQ(rows[size_t(b)].grasps, 1);
	EXPECT_NEAR(rows[size_t(a)].dwell, 0.4, 1e-12);
	EXPECT_NEAR(rows[size_t(b)].meanForce, 3.5, 1e-12);
	EXPECT_NEAR(rows[size_t(b)].impulse, 1.4, 1e-12);
	EXPECT_EQ(rows[size_t(b)].peakForce, 4);
	int byA = 0, byB = 0;
	for (const HeatMap::Vertex& v : map.vertices())
	{
		if (v.part < 0) continue;
		++(v.part == a ? byA : byB);
		EXPECT_EQ(v.contact, v.part == a ? 1 : 0.25);
		EXPECT_NEAR(v.dwell, 0.4, 1e-6);
	}
	EXPECT_GT(byA, 4);
	EXPECT_EQ(byA, byB);
	for (const HeatMap::Vertex& v : map.vertices(a)) EXPECT_NE(v.part, b);
}

TEST(HeatMap, APlaceThatDifferentPartsTouchedInTwoGraspsWasTouchedInBoth)
{
	HeatMap map(gridBox({0.01, 0.01, 0.01}, 20));
	const int a = map.addPart("R_Index3", 43, ist::makeSphereMesh(0.005, 3)),
			  b = map.addPart("R_Thumb3", 55, ist::makeSphereMesh(0.005, 3)), none = map.addPart("nothing", 1, {});
	const HeatMapContact above{{{}, {0, 0.0145, 0}}, 1, {0, 0.01, 0}, 0.1};
	map.add(a, above);
	map.beginGrasp();
	map.add(b, above);
	map.add(none, above);
	map.beginGrasp();
	double most = 0, mostOfA = 0;
	for (const HeatMap::Vertex& v : map.vertices()) most = std::max(most, v.contact);
	for (const HeatMap::Vertex& v : map.vertices(a)) mostOfA = std::max(mostOfA, v.contact);
	EXPECT_NEAR(most, 2.0 / 3, 1e-12);
	EXPECT_NEAR(mostOfA, 1.0 / 3, 1e-12);
	EXPECT_EQ(map.summary()[size_t(none)].grasps, 0);
}

TEST(HeatMap, ShortMomentsAddUpOverALongTime)
{
	HeatMap map(ist::makeBoxMesh({0.1, 0.1, 0.1}));
	const int tip = map.addPart("tip", 43, ist::makeSphereMesh(0.005, 0));
	const HeatMapContact contact{{{}, {0.09, 0.1045, 0.08}}, 1, {0.09, 0.1, 0.08}, 1e-3};
	map.add(tip, {contact.X_OP, 1, contact.point, 1e5});
	for (int i = 0; i < 1000; ++i) map.add(tip, contact);
	double dwell = 0;
	for (const HeatMap::Vertex& v : map.vertices()) dwell += v.dwell;
	EXPECT_NEAR(dwell, 1e5 + 1, 1e-6);
}

TEST(HeatMap, OfAPartThatIsNotThereSaysNothing)
{
	HeatMap map(ist::makeBoxMesh({0.1, 0.1, 0.1}));
	map.add(map.addPart("tip", 43, ist::makeSphereMesh(0.005, 0)), {{{}, {0.09, 0.1045, 0.08}}, 1, {0.09, 0.1, 0.08}, 0.1});
	for (const HeatMap::Vertex& v : map.vertices(1)) EXPECT_TRUE(v.part == -1 && v.contact == 0 && v.dwell == 0);
	const auto refused = saveHeatMap(map, "/nowhere/map.ply", HeatMapColours::Fingers, 7);
	ASSERT_TRUE(refused);
	EXPECT_EQ(refused->message, "the heat map has no part 7, only 1");
}

TEST(HeatMap, CountsNothingThatIsNotFiniteAndDoesNotAllocate)
{
	HeatMap map(gridBox({0.01, 0.01, 0.01}, 20));
	const int part = map.addPart("tip", 43, ist::makeSphereMesh(0.005, 3));
	const HeatMapContact good{{{}, {0, 0.0145, 0}}, 1, {0, 0.01, 0}, 0.1};
	HeatMapContact bad = good;
	bad.force = std::numeric_limits<double>::quiet_NaN();
	map.add(part, bad);
	bad = good;
	bad.X_OP.rotation.m[0][0] = 3;
	map.add(part, bad);
	bad = good;
	bad.seconds = -1;
	map.add(part, bad);
	map.add(7, good);
	map.add(-1, good);
	EXPECT_EQ(map.summary()[0].dwell, 0);
	const long before = allocationCount();
	const HeatMapTouch touch = map.add(part, good);
	HeatMapContact grazing = good;
	grazing.X_OP.translation.y = 0.0151;
	map.add(part, grazing);
	EXPECT_EQ(allocationCount(), before);
	EXPECT_GT(touch.area, 0);
}

TEST(HeatMap, InSharesItIsTheSameMap)
{
	for (const int share : {1, 7, 40})
	{
		HeatMap whole(gridBox({0.01, 0.01, 0.01}, 20)), shared(gridBox({0.01, 0.01, 0.01}, 20));
		for (HeatMap* map : {&whole, &shared}) map->addPart("tip", 43, ist::makeSphereMesh(0.005, 3));
		int most = 0;
		for (int i = 0; i < 4; ++i)
		{
			const HeatMapContact contact{{{}, {0.002 * i, 0.0135 + 0.0006 * i, 0.001 * i}}, 1.0 + i, {0.002 * i, 0.01, 0.001 * i}, 0.1};
			whole.add(0, contact);
			// A contact that another one replaces before its end has no effect.
			shared.begin(0, {{{}, {0, 0.013, 0}}, 50, {0, 0.01, 0}, 1});
			int budget = share;
			EXPECT_FALSE(shared.advance(budget));
			EXPECT_LE(budget, 0);
			shared.begin(0, contact);
			int turns = 1;
			for (budget = share; !shared.advance(budget); budget = share) ++turns;
			most = std::max(most, turns);
			EXPECT_TRUE(shared.advance(budget)) << "nothing was begun";
		}
		EXPECT_GT(most, 1);
		const HeatMap::Summary a = whole.summary()[0], b = shared.summary()[0];
		EXPECT_EQ(a.area, b.area);
		EXPECT_EQ(a.dwell, b.dwell);
		EXPECT_EQ(a.impulse, b.impulse);
		EXPECT_EQ(a.peakPressure, b.peakPressure);
		const std::vector<HeatMap::Vertex> of = whole.vertices(), in = shared.vertices();
		for (size_t v = 0; v < of.size(); ++v) ASSERT_EQ(of[v].impulse, in[v].impulse);
	}
}

namespace
{
/// The vertices of a file that saveHeatMap wrote, by the file's own header.
struct PlyVertex
{
	float place[3];
	uint8_t colour[3];
	float values[5];
	int32_t part;
};
/// `others`: receives the property file_vertex, if the file has it.
std::vector<PlyVertex> readPly(const std::string& path, std::vector<int32_t>* others = nullptr)
{
	std::ifstream file(path, std::ios::binary);
	const std::string bytes{std::istreambuf_iterator<char>(file), {}};
	const size_t begin = bytes.find("end_header\n") + 11;
	size_t count = 0;
	std::istringstream(bytes.substr(bytes.find("element vertex ") + 15)) >> count;
	std::vector<PlyVertex> all(count);
	const char* at = bytes.data() + begin;
	const bool hasOthers = bytes.find("property int file_vertex\n") < begin;
	for (PlyVertex& v : all)
	{
		std::memcpy(v.place, at, 12);
		std::memcpy(v.colour, at + 12, 3);
		std::memcpy(v.values, at + 15, 20);
		std::memcpy(&v.part, at + 35, 4);
		at += 39;
		if (!hasOthers) continue;
		int32_t other = 0;
		std::memcpy(&other, at, 4);
		if (others) others->push_back(other);
		at += 4;
	}
	return all;
}
}  // namespace

TEST(HeatMapFile, PlyAndTableCanBeReadByOthers)
{
	const std::string folder = (std::filesystem::temp_directory_path() / ("heatmap" + std::to_string(std::random_device()()))).string();
	std::filesystem::create_directory(folder);
	HeatMap map(gridBox({0.01, 0.01, 0.01}, 20));
	const int index = map.addPart("R_Index3", 43, ist::makeSphereMesh(0.005, 3));
	map.add(index, {{{}, {0, 0.0145, 0}}, 1, {0, 0.01, 0}, 0.1});
	map.beginGrasp();
	ASSERT_FALSE(saveHeatMap(map, folder + "/map.ply"));
	ASSERT_FALSE(saveHeatMap(map, folder + "/grey.ply", HeatMapColours::ContactPose));
	ASSERT_FALSE(saveHeatMapTable(map, folder + "/map.csv"));

	// Another reader of PLY gets the same surface.
	const auto read = ist::importMesh(folder + "/map.ply");
	ASSERT_TRUE(read) << read.error().message;
	EXPECT_EQ(read.value().triangles.size(), map.mesh().triangles.size());
	EXPECT_NEAR(massProperties(read.value()).volume, 8e-6, 1e-11);

	const auto values = map.vertices();
	const auto colours = readPly(folder + "/map.ply"), greys = readPly(folder + "/grey.ply");
	ASSERT_EQ(colours.size(), values.size());
	for (size_t v = 0; v < values.size(); ++v)
	{
		EXPECT_EQ(colours[v].part, values[v].part == index ? 43 : 0);
		EXPECT_FLOAT_EQ(colours[v].values[0], float(values[v].contact));
		EXPECT_FLOAT_EQ(colours[v].values[2], float(values[v].impulse));
		EXPECT_FLOAT_EQ(colours[v].values[4], float(values[v].peak));
		EXPECT_EQ(colours[v].colour[0] < colours[v].colour[2], values[v].part == index);  // the index finger is blue
		EXPECT_EQ(greys[v].colour[0], values[v].part == index ? 128 : 1);
		EXPECT_EQ(greys[v].colour[0], greys[v].colour[2]);
	}
	std::ifstream csv(folder + "/map.csv");
	std::string header, row;
	std::getline(csv, header), std::getline(csv, row);
	EXPECT_EQ(header.rfind("part,id,area_m2,dwell_s,mean_force_N", 0), 0u);
	EXPECT_EQ(row.rfind("R_Index3,43,", 0), 0u);
	EXPECT_EQ(std::count(header.begin(), header.end(), ','), std::count(row.begin(), row.end(), ','));
	EXPECT_TRUE(saveHeatMap(map, folder + "/none/map.ply"));
	csv.close();  // Windows removes no file that is open
	std::filesystem::remove_all(folder);
}

// A file lists the vertices of the map in reverse, one of them twice, one in a place where the map has none, and without the last ten.
TEST(HeatMapFile, TheVerticesOfAFileComeFirstAndInItsOrder)
{
	const std::string folder = (std::filesystem::temp_directory_path() / ("heatmap" + std::to_string(std::random_device()()))).string();
	std::filesystem::create_directory(folder);
	HeatMap map(gridBox({0.01, 0.01, 0.01}, 20));
	const int index = map.addPart("R_Index3", 43, ist::makeSphereMesh(0.005, 3));
	map.add(index, {{{}, {0, 0.0145, 0}}, 1, {0, 0.01, 0}, 0.1});
	const std::vector<Vec3>& places = map.mesh().vertices;
	const std::vector<HeatMap::Vertex> values = map.vertices();
	const size_t count = places.size(), left = 10;
	std::vector<Vec3> file(places.rbegin(), places.rend() - left);
	std::vector<int64_t> vertexOf;
	for (size_t i = 0; i < file.size(); ++i) vertexOf.push_back(int64_t(count - 1 - i));
	file.push_back(file[3]), vertexOf.push_back(vertexOf[3]);
	file.push_back({1, 2, 3}), vertexOf.push_back(-1);

	ASSERT_FALSE(saveHeatMapOfFile(map, file, folder + "/map.ply"));
	std::vector<int32_t> rows;
	const auto written = readPly(folder + "/map.ply", &rows);
	ASSERT_EQ(written.size(), file.size() + left);
	ASSERT_EQ(rows.size(), written.size());
	int touched = 0;
	for (size_t i = 0; i < written.size(); ++i)
	{
		const bool isOfFile = i < file.size();
		EXPECT_EQ(rows[i], isOfFile ? int32_t(i) : -1);
		const int64_t vertex = isOfFile ? vertexOf[i] : int64_t(i - file.size());
		const HeatMap::Vertex value = vertex < 0 ? HeatMap::Vertex() : values[size_t(vertex)];
		EXPECT_FLOAT_EQ(written[i].values[2], float(value.impulse)) << i;
		EXPECT_EQ(written[i].part, value.part == index ? 43 : 0);
		const Vec3 place = isOfFile ? file[i] : places[size_t(vertex)];
		EXPECT_NEAR(norm(Vec3{written[i].place[0], written[i].place[1], written[i].place[2]} - place), 0, 1e-6);
		touched += value.part == index;
	}
	EXPECT_GT(touched, 3);
	// The triangles have their corners where they had them.
	const auto read = ist::importMesh(folder + "/map.ply");
	ASSERT_TRUE(read) << read.error().message;
	ASSERT_EQ(read.value().triangles.size(), map.mesh().triangles.size());
	for (size_t t = 0; t < read.value().triangles.size(); ++t)
		for (size_t c = 0; c < 3; ++c)
			ASSERT_NEAR(norm(read.value().vertices[read.value().triangles[t][c]] - places[map.mesh().triangles[t][c]]), 0, 1e-6);

	// Where no vertex was added there is no further property.
	const std::vector<Vec3> all(places.rbegin(), places.rend());
	ASSERT_FALSE(saveHeatMapOfFile(map, all, folder + "/all.ply"));
	std::vector<int32_t> none;
	EXPECT_EQ(readPly(folder + "/all.ply", &none).size(), count);
	EXPECT_TRUE(none.empty());

	const auto refused = saveHeatMapOfFile(map, {{1, 2, 3}}, folder + "/none.ply");
	ASSERT_TRUE(refused);
	EXPECT_NE(refused->message.find("none of the 1 vertices"), std::string::npos);
	EXPECT_FALSE(std::filesystem::exists(folder + "/none.ply"));
	std::filesystem::remove_all(folder);
}

// Two slabs lie on a slab: the left one in both grasps, the right one in the second, at rest and then deeper.
TEST(HeatMapFile, TheTableHasEveryColumnOfManyGrasps)
{
	const double a = 0.006, d = 0.0002;
	HeatMap map(gridBox({0.01, 0.005, 0.01}, 100));
	const Mesh slab = ist::makeBoxMesh({a / 2, 0.01, a / 2});
	const int left = map.addPart("L_Thumb3", 40, slab), right = map.addPart("R_Thumb3", 55, slab);
	map.addPart("R_Pinky1", 47, slab);
	const auto press = [&](int part, double x, double depth, double seconds) {
		const Pose X{rotationMatrix(ist::quaternionFromRotationVector({0, 0.4, 0})), {x, 0.015 - depth, 0.0003}};
		map.add(part, {X, kK * a * a * depth, {x, 0.005, 0}, seconds});
	};
	press(left, -0.005, d, 0.25);
	map.beginGrasp();
	press(left, -0.005, d, 0.25);
	press(right, 0.005, d, 0.75);
	press(right, 0.005, 3 * d, 0.25);

	std::istringstream table(heatMapTable(map));
	std::string header, line;
	std::getline(table, header);
	EXPECT_EQ(header, "part,id,area_m2,dwell_s,mean_force_N,peak_force_N,impulse_Ns,grasps,largest_depth_m,peak_pressure_Pa");
	const double force = kK * a * a * d;
	const struct
	{
		const char* part;
		double values[9];
	} rows[] = {{"L_Thumb3", {40, a * a, 0.5, force, force, 0.5 * force, 2, d, kK * d}},
		{"R_Thumb3", {55, a * a, 1, 1.5 * force, 3 * force, 1.5 * force, 1, 3 * d, kK * 3 * d}}};
	for (const auto& row : rows)
	{
		ASSERT_TRUE(std::getline(table, line));
		std::replace(line.begin(), line.end(), ',', ' ');
		std::istringstream cells(line);
		std::string name;
		cells >> name;
		EXPECT_EQ(name, row.part);
		for (size_t i = 0; i < 9; ++i)
		{
			double value = 0;
			ASSERT_TRUE(cells >> value) << i;
			// The area is that of the vertices inside, which are 0.2 mm apart.
			EXPECT_NEAR(value, row.values[i], (i == 1 ? 0.03 : 0.02) * row.values[i]) << name << " " << i;
		}
	}
	EXPECT_FALSE(std::getline(table, line));  // the little finger touched nothing
}

TEST(HeatMapFile, FingersHaveTheirOwnColours)
{
	const auto same = [](int a, int b) {
		const HeatMapColour x = handPartColour(a), y = handPartColour(b);
		return x.r == y.r && x.g == y.g && x.b == y.b;
	};
	EXPECT_TRUE(same(41, 43));
	EXPECT_TRUE(same(41, 26));
	EXPECT_FALSE(same(43, 44));
	EXPECT_FALSE(same(55, 22));
	EXPECT_TRUE(same(21, 22));
}
