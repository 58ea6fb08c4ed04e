// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/AssetSections.h"

namespace ist
{
namespace
{
constexpr size_t kNodeBytes = BallNode::kWidth * 5 * 4;
constexpr size_t kBlockBytes = BallBlock::kWidth * 4 * 4 + 5 * 4;
constexpr size_t kBallBytes = 10 * 4;

/// Padding is what it is, whatever the file says.
void clearPadding(BallTree& tree)
{
	constexpr float kFarAway = 1e17f;
	for (size_t i = 0; i < tree.balls.size(); ++i)
	{
		BallBlock& block = tree.blocks[i / BallBlock::kWidth];
		const size_t lane = i % BallBlock::kWidth;
		if (lane < block.count) continue;
		tree.balls[i] = {};
		tree.balls[i].x = tree.balls[i].y = tree.balls[i].z = block.x[lane] = block.y[lane] = block.z[lane] = kFarAway;
		block.R[lane] = 0;
	}
}

void readTree(ByteReader& r, BallTree& tree)
{
	tree.nodes.resize(r.count(kNodeBytes));
	for (BallNode& n : tree.nodes)
	{
		for (float* lane : {n.x, n.y, n.z, n.r})
			for (int i = 0; i < BallNode::kWidth; ++i) lane[i] = r.f32();
		for (uint32_t& child : n.child) child = r.u32();
	}
	tree.blocks.resize(r.count(kBlockBytes));
	for (BallBlock& b : tree.blocks)
	{
		for (float* lane : {b.x, b.y, b.z, b.R})
			for (int i = 0; i < BallBlock::kWidth; ++i) lane[i] = r.f32();
		b.count = r.u32();
		for (float* v : {&b.bx, &b.by, &b.bz, &b.br}) *v = r.f32();
	}
	tree.balls.resize(r.count(kBallBytes));
	for (MomentEllipsoid& b : tree.balls)
	{
		for (float* v : {&b.x, &b.y, &b.z, &b.R, &b.density, &b.nx, &b.ny, &b.nz, &b.depth}) *v = r.f32();
		b.sphere = r.u32();
		b.xx = b.yy = b.zz = b.R * b.R;
	}
	if (tree.balls.size() == tree.blocks.size() * BallBlock::kWidth) clearPadding(tree);
}

bool namesSpheres(const BallTree& tree, size_t sphereCount)
{
	for (size_t i = 0; i < tree.balls.size() && i / BallBlock::kWidth < tree.blocks.size(); ++i)
		if (i % BallBlock::kWidth < tree.blocks[i / BallBlock::kWidth].count && tree.balls[i].sphere >= sphereCount) return false;
	return true;
}

/// Version 2 keeps no more of an inner ball than the index of its sphere: both must be the same ball.
bool agree(const BallTree& inner, const std::vector<Sphere>& spheres)
{
	if (!namesSpheres(inner, spheres.size()) || inner.ballCount() != spheres.size()) return false;
	if (inner.balls.size() != inner.blocks.size() * BallBlock::kWidth) return false;
	std::vector<char> seen(spheres.size());
	for (size_t i = 0; i < inner.balls.size(); ++i)
	{
		if (i % BallBlock::kWidth >= inner.blocks[i / BallBlock::kWidth].count) continue;
		const MomentEllipsoid& b = inner.balls[i];
		const Sphere& s = spheres[b.sphere];
		if (seen[b.sphere] || b.density != 1 || b.x != s.x || b.y != s.y || b.z != s.z || b.R != s.r) return false;
		seen[b.sphere] = 1;
	}
	return true;
}

SectionState state(bool good)
{
	return good ? SectionState::Doubtful : SectionState::Bad;
}
}  // namespace

SectionState decodeSectionVersion1(uint32_t id, const std::byte* bytes, size_t size, InnerSphereTree& tree)
{
	ByteReader r(bytes, size);
	switch (id)
	{
		case kLawSection: readTree(r, tree.law); return state(r.complete() && namesSpheres(tree.law, tree.spheres.size()));
		case kCellSection: readTree(r, tree.cells); return state(r.complete() && namesSpheres(tree.cells, tree.spheres.size()));
		case kInnerSection: readTree(r, tree.inner); return state(r.complete() && agree(tree.inner, tree.spheres));
		default: return decodeSection(id, bytes, size, tree);
	}
}
}  // namespace ist
