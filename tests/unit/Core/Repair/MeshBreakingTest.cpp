// SPDX-License-Identifier: Zlib
#include "tests/unit/Core/Repair/RepairChecks.h"
#include "tests/unit/SolidAngleWinding.h"

#include <array>
#include <map>
#include <random>

using namespace ist;

namespace
{
constexpr int kSeeds = 1000;

using Random = std::mt19937_64;

double uniform(Random& random, double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }

Vec3 direction(Random& random)
{
	std::normal_distribution<double> normal;
	return normalized({normal(random), normal(random), normal(random)});
}

/// Volume as the sum of signed tetrahedra about a vertex.
double volumeOf(const Mesh& mesh)
{
	if (mesh.triangles.empty()) return 0;
	const Vec3 o = mesh.vertices[mesh.triangles[0][0]];
	double sum = 0;
	for (const auto& t : mesh.triangles) sum += dot(mesh.vertices[t[0]] - o, cross(mesh.vertices[t[1]] - o, mesh.vertices[t[2]] - o)) / 6;
	return sum;
}

/// Whether triangles run through every edge as often one way as the other. Edges are named by the positions of their ends.
bool isBalanced(const Mesh& mesh)
{
	using Position = std::array<double, 3>;
	const auto position = [&](uint32_t v) {
		return Position{mesh.vertices[v].x + 0.0, mesh.vertices[v].y + 0.0, mesh.vertices[v].z + 0.0};
	};
	std::map<std::pair<Position, Position>, int> balance;
	for (const auto& t : mesh.triangles)
		for (std::size_t k = 0; k < 3; ++k)
		{
			const Position a = position(t[k]), b = position(t[(k + 1) % 3]);
			if (a != b) balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
		}
	for (const auto& [edge, sum] : balance)
		if (sum != 0) return false;
	return true;
}

Mesh goodMesh(Random& random)
{
	switch (random() % 7)
	{
	case 0: return makeTetrahedronMesh(1);
	case 1: return makeBoxMesh({1, 0.5, 0.8});
	case 2: return makeSphereMesh(1, 2);
	case 3: return makeTorusMesh(1, 0.4, 14, 8);
	case 4: return makeCylinderMesh(0.5, 1, 12);
	case 5: return joined(makeBoxMesh({1, 1, 1}), translated(makeSphereMesh(0.5, 1), {2.5, 0, 0}));
	default:
	{
		Mesh cavity = makeSphereMesh(0.5, 1);
		for (auto& t : cavity.triangles) std::swap(t[1], t[2]);
		return joined(makeBoxMesh({1, 1, 1}), cavity);
	}
	}
}

std::size_t anyTriangle(const Mesh& mesh, Random& random) { return random() % mesh.triangles.size(); }

void breakOnce(Mesh& mesh, Random& random, double size)
{
	const std::size_t i = anyTriangle(mesh, random);
	switch (random() % 6)
	{
	case 0: mesh.triangles.erase(mesh.triangles.begin() + std::ptrdiff_t(i)); break;
	case 1: mesh.triangles.push_back(mesh.triangles[i]); break;
	case 2: mesh.triangles.push_back({mesh.triangles[i][1], mesh.triangles[i][0], mesh.triangles[i][2]}); break;
	case 3: std::swap(mesh.triangles[i][0], mesh.triangles[i][2]); break;
	case 4:  // the triangle gets its own corner, slightly displaced
	{
		mesh.vertices.push_back(mesh.vertices[mesh.triangles[i][1]] + direction(random) * (size * std::pow(10, uniform(random, -12, -2))));
		mesh.triangles[i][1] = static_cast<uint32_t>(mesh.vertices.size() - 1);
		break;
	}
	default: mesh.triangles[i][2] = mesh.triangles[i][random() % 2]; break;
	}
}

struct Broken
{
	Mesh mesh;
	double volume = 0;  ///< volume before the mesh was broken
};

Broken brokenMesh(uint64_t seed)
{
	Random random(seed);
	const double scale = std::pow(10, uniform(random, -3, 3)), far = random() % 4 == 0 ? 1000 : 1;
	Mesh mesh = goodMesh(random);
	for (Vec3& v : mesh.vertices) v = scale * (v + direction(random) * 0.02);
	const Pose X{rotationMatrix(quaternionFromRotationVector(direction(random) * 3)), direction(random) * (far * scale)};
	mesh = transformed(mesh, X);
	Broken broken{mesh, volumeOf(mesh)};
	const std::size_t most = 1 + mesh.triangles.size() / 8;
	for (std::size_t k = 1 + random() % most; k > 0 && !broken.mesh.triangles.empty(); --k) breakOnce(broken.mesh, random, scale);
	return broken;
}
}  // namespace

TEST(MeshBreaking, EveryBrokenMeshIsMadeGoodWithinWhatIsReportedOrRefusedInWords)
{
	int built = 0, untouched = 0;
	for (uint64_t seed = 1; seed <= kSeeds; ++seed)
	{
		SCOPED_TRACE(seed);
		const Broken broken = brokenMesh(seed);
		const Result<RepairedMesh> repaired = repair(broken.mesh);
		if (!repaired)
		{
			EXPECT_FALSE(repaired.error().cancelled);
			EXPECT_GT(repaired.error().message.size(), 20u);
			EXPECT_NE(repaired.error().message.find(';'), std::string::npos) << repaired.error().message;
			continue;
		}
		++built;
		const RepairedMesh& r = repaired.value();
		EXPECT_TRUE(isBalanced(r.mesh));
		EXPECT_TRUE(std::isfinite(r.volumeBefore) && std::isfinite(r.volumeDoubt));
		const double volume = volumeOf(r.mesh), side = bounds(broken.mesh).longestSide();
		EXPECT_GT(volume, 0);
		EXPECT_NEAR(volume, r.volumeAfter, 1e-9 * side * side * side);
		// Corners that are moved by 1e-9 of the size and welded again change the volume by no more than that.
		EXPECT_LE(std::fabs(volume - broken.volume), r.volumeDoubt + 1e-8 * side * side * side);
		untouched += r.volumeDoubt == 0;
		Random random(seed + 77);
		const Box box = bounds(r.mesh);
		for (int i = 0; i < 8; ++i)
		{
			const Vec3 p = box.lower +
				Vec3{uniform(random, 0, 1) * box.size().x, uniform(random, 0, 1) * box.size().y, uniform(random, 0, 1) * box.size().z};
			const double w = windingNumber(r.mesh, p);
			EXPECT_NEAR(w, std::round(w), 1e-6);
		}
	}
	EXPECT_GT(built, kSeeds * 9 / 10);
	EXPECT_GT(untouched, kSeeds / 20);
	EXPECT_LT(untouched, kSeeds);
}

TEST(MeshBreaking, WhatIsWrappedIsClosedToo)
{
	for (uint64_t seed = 1; seed <= kSeeds; seed += kSeeds / 8)
	{
		SCOPED_TRACE(seed);
		const Broken broken = brokenMesh(seed);
		const Result<RepairedMesh> repaired = repair(broken.mesh, RepairMode::Wrap);
		if (!repaired) continue;
		EXPECT_TRUE(isBalanced(repaired.value().mesh));
		EXPECT_GT(volumeOf(repaired.value().mesh), 0);
	}
}
