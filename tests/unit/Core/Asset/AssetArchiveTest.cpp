// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Asset/AssetArchive.h"

#include "BulletISTCollision/Core/Base/SymmetricEigen.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Query/OverlapQuery.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>

namespace ist
{
namespace
{
/// A concave body away from its origin, and the body that an archive returns.
struct Packed
{
	InnerSphereTree tree, archived;
	size_t bytes = 0;
};

const Packed& packedTorus()
{
	static const Packed packed = [] {
		BuildOptions options;
		options.maxSpheres = 1500;
		Packed p;
		Result<InnerSphereTree> built = buildTree(translated(makeTorusMesh(0.3, 0.1, 48, 24), {100, -3, 20}), options);
		EXPECT_TRUE(built) << built.error().message;
		p.tree = std::move(built).value();
		const Result<std::vector<std::byte>> bytes = encodeArchive(p.tree);
		EXPECT_TRUE(bytes) << bytes.error().message;
		p.bytes = bytes.value().size();
		Result<InnerSphereTree> back = decodeArchive(bytes.value().data(), bytes.value().size());
		EXPECT_TRUE(back) << back.error().message;
		p.archived = std::move(back).value();
		return p;
	}();
	return packed;
}

TEST(AssetArchive, TakesAtMostFortyBytesASphereAndTheSurface)
{
	const Packed& p = packedTorus();
	EXPECT_LE(p.bytes, 40 * p.tree.spheres.size() + p.tree.surface.bytes());
	EXPECT_EQ(p.archived.spheres.size(), p.tree.spheres.size());
	EXPECT_EQ(p.archived.law.ballCount(), p.tree.law.ballCount());
	EXPECT_EQ(p.archived.provenance.meshHash, p.tree.provenance.meshHash);
	EXPECT_EQ(p.archived.origin, p.tree.origin);
}

// Original balls neither overlap each other nor leave the body. So balls inside them do not either.
TEST(AssetArchive, EachSphereLiesInsideItsOriginal)
{
	const Packed& p = packedTorus();
	const double side = p.tree.box.longestSide();
	for (size_t i = 0; i < p.tree.spheres.size(); ++i)
	{
		const Sphere &a = p.tree.spheres[i], &b = p.archived.spheres[i];
		const double shift = distance(a.center(), b.center());
		ASSERT_GT(b.r, 0);
		ASSERT_LE(shift + b.r, double(a.r)) << i;
		// The tolerance is half a diagonal of a grid cell and of a float, and a step of the radius code.
		EXPECT_LE(shift, side / (1 << 21) * 0.87 + side * 1.1e-7);
		EXPECT_GE(b.r, a.r - shift - 1e-5 * a.r);
	}
	for (size_t i = 0; i < p.archived.spheres.size(); ++i)
		for (size_t j = 0; j < i; ++j)
		{
			const Sphere &a = p.archived.spheres[i], &b = p.archived.spheres[j];
			ASSERT_GE(distance(a.center(), b.center()), double(a.r) + b.r);
		}
	EXPECT_LE(p.archived.fill, p.tree.fill);
	EXPECT_GE(p.archived.fill, p.tree.fill * (1 - 1e-3));
	EXPECT_GE(p.archived.maxGap, p.tree.maxGap);
}

// The archive does not store cells: they are the sums of their leaves.
TEST(AssetArchive, CellsComeBackFromTheirLeaves)
{
	const Packed& p = packedTorus();
	const auto bySphere = [](const InnerSphereTree& tree) {
		std::vector<MomentEllipsoid> cells(tree.spheres.size());
		for (const MomentEllipsoid& cell : tree.cells.slots())
			if (cell.density > 0) cells[cell.sphere] = cell;
		return cells;
	};
	const std::vector<MomentEllipsoid> before = bySphere(p.tree), after = bySphere(p.archived);
	for (size_t i = 0; i < before.size(); ++i)
	{
		const MomentEllipsoid &a = before[i], &b = after[i];
		EXPECT_LE(distance(a.center(), b.center()), 1e-3 * a.R) << i;
		// The tolerances are half steps of the leaves' codes: 0.3 % of a volume, 0.6 % of a mean square in the shape, 0.1 % in a
		// normal.
		EXPECT_NEAR(b.volume(), a.volume(), 3e-3 * a.volume()) << i;
		EXPECT_NEAR(b.meanRadius(), a.meanRadius(), 3e-3 * a.meanRadius()) << i;
		EXPECT_NEAR(b.R, a.R, 6e-3 * a.R) << i;
		EXPECT_LE(norm(a.normal() - b.normal()), 2e-3) << i;
		EXPECT_NEAR(b.depth, a.depth, 1e-3 * a.depth + 1e-5) << i;
	}
}

/// Whether a leaf is thinner than a tenth of its length, or its ellipsoid has less than 0.4 of the leaf's volume.
bool isThin(const MomentEllipsoid& leaf)
{
	const SymmetricMatrix3 P = leaf.shape();
	const double matrix[3][3] = {{P.xx, P.xy, P.xz}, {P.xy, P.yy, P.yz}, {P.xz, P.yz, P.zz}};
	SymmetricEigen<3> eigen;
	EXPECT_TRUE(eigen.decompose(matrix));
	const auto& squares = eigen.values;
	const auto [least, most] = std::minmax_element(std::begin(squares), std::end(squares));
	return *least < 0.01 * *most || 4.18879 * std::sqrt(squares[0] * squares[1] * squares[2]) < 0.4 * leaf.volume();
}

TEST(AssetArchive, LeavesKeepTheirShapesAsFarAsIsPromised)
{
	// A plate, and two thinner plates that cross: at the crossing some leaves are thin.
	const Mesh sheet = makeBoxMesh({0.5, 0.5, 0.0015});
	Mesh crossed = sheet;
	for (const auto& t : sheet.triangles) crossed.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
	for (const Vec3& v : transformed(sheet, {rotationMatrix(quaternionFromRotationVector({1.3, 0, 0})), {}}).vertices)
		crossed.vertices.push_back(v);
	const Pose X = {rotationMatrix(quaternionFromRotationVector({0.3, 1, -0.5})), {100, 2, 3}};
	BuildOptions options;
	options.maxSpheres = 1500;
	int thin = 0, thick = 0;
	for (const Mesh& mesh : {transformed(makeBoxMesh({0.5, 0.5, 0.005}), X), transformed(crossed, X)})
	{
		const Result<InnerSphereTree> built = buildTree(mesh, options);
		ASSERT_TRUE(built) << built.error().message;
		const Result<std::vector<std::byte>> bytes = encodeArchive(built.value());
		ASSERT_TRUE(bytes) << bytes.error().message;
		const Result<InnerSphereTree> back = decodeArchive(bytes.value().data(), bytes.value().size());
		ASSERT_TRUE(back) << back.error().message;
		std::vector<std::vector<MomentEllipsoid>> ofSphere(built.value().spheres.size());
		for (const MomentEllipsoid& leaf : back.value().law.slots())
			if (leaf.density > 0) ofSphere[leaf.sphere].push_back(leaf);
		for (const MomentEllipsoid& a : built.value().law.slots())
		{
			if (!(a.density > 0)) continue;
			const std::vector<MomentEllipsoid>& leaves = ofSphere[a.sphere];
			ASSERT_FALSE(leaves.empty());
			const MomentEllipsoid& b = *std::min_element(
				leaves.begin(), leaves.end(), [&](const MomentEllipsoid& one, const MomentEllipsoid& other) {
					return distance(one.center(), a.center()) < distance(other.center(), a.center());
				});
			const bool isThinLeaf = isThin(a);
			++(isThinLeaf ? thin : thick);
			EXPECT_NEAR(b.volume(), a.volume(), 5e-3 * a.volume());
			EXPECT_NEAR(b.meanRadius(), a.meanRadius(), (isThinLeaf ? 0.1 : 1e-3) * a.meanRadius());
			if (isThinLeaf) continue;
			const SymmetricMatrix3 P = a.shape(), Q = b.shape();
			const double most = 0.013 * P.trace() / 3;
			EXPECT_NEAR(Q.xx, P.xx, most);
			EXPECT_NEAR(Q.yy, P.yy, most);
			EXPECT_NEAR(Q.zz, P.zz, most);
			EXPECT_NEAR(Q.xy, P.xy, most);
			EXPECT_NEAR(Q.xz, P.xz, most);
			EXPECT_NEAR(Q.yz, P.yz, most);
		}
	}
	EXPECT_GT(thin, 500);
	EXPECT_GT(thick, 2000);
}

TEST(AssetArchive, LosesLessThanATenthOfTheErrorBarOverRandomPoses)
{
	const Packed& p = packedTorus();
	std::mt19937_64 random(5);
	std::uniform_real_distribution<double> unit(-1, 1);
	QueryWorkspace workspace;
	int touching = 0;
	double volumeLoss2 = 0, forceLoss2 = 0;
	for (int i = 0; i < 200; ++i)
	{
		const Vec3 axis = normalized({unit(random), unit(random), unit(random)});
		const double angle = 3.1 * unit(random);
		Pose X;
		X.rotation = rotationMatrix(quaternionFromRotationVector(angle * axis));
		// B is turned about the centre of the body, which is far from the origin of the mesh, and then moved.
		const Vec3 shift{0.4 * unit(random), 0.4 * unit(random), 0.2 * unit(random)};
		X.translation = p.tree.origin + shift - X.rotation * p.tree.origin;
		const OverlapResult answer = queryOverlap(p.tree, p.tree, X, workspace);
		const OverlapIntegrals a = answer.total;
		const OverlapIntegrals b = queryOverlap(p.archived, p.archived, X, workspace).total;
		if (a.volume < 1e-3 * p.tree.volume) continue;
		++touching;
		const OverlapError sigma = overlapError(answer, p.tree, p.tree, 1);
		EXPECT_LE(std::fabs(b.volume - a.volume), 0.1 * sigma.volume) << i;
		const double force = norm(pressureWrench(b, {}).force - pressureWrench(a, {}).force);
		EXPECT_LE(force, 0.1 * sigma.force) << i;
		volumeLoss2 += std::pow(b.volume / a.volume - 1, 2);
		forceLoss2 += std::pow(force / a.volume, 2);
	}
	EXPECT_GT(touching, 50);
	RecordProperty("rms_volume_loss", std::to_string(std::sqrt(volumeLoss2 / touching)));
	RecordProperty("rms_force_loss", std::to_string(std::sqrt(forceLoss2 / touching)));
	EXPECT_LE(std::sqrt(volumeLoss2 / touching), 1e-3);
	EXPECT_LE(std::sqrt(forceLoss2 / touching), 1e-3);
}

TEST(AssetArchive, RefusesASphereThatTheGridCannotHold)
{
	InnerSphereTree tree = packedTorus().tree;
	std::vector<Sphere> spheres(tree.spheres.begin(), tree.spheres.end());
	spheres.back().r = 1e-8f;
	tree.spheres = spheres;
	const Result<std::vector<std::byte>> refused = encodeArchive(tree);
	ASSERT_FALSE(refused);
	EXPECT_NE(refused.error().message.find("too small"), std::string::npos);
}
}  // namespace
}  // namespace ist
