// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/AssetSections.h"

#include "BulletISTCollision/Core/LargeArray.h"
#include "BulletISTCollision/Core/TreeCheck.h"

namespace ist
{
namespace
{
constexpr size_t kNodeBytes = BallNode::kWidth * 5 * 4;
constexpr size_t kHeadBytes = 5 * 4;
constexpr size_t kBallBytes = 16 * 4;
constexpr size_t kIndexBytes = 4;
constexpr size_t kSphereBytes = 4 * 4;
constexpr size_t kWidth = BallBlock::kWidth;
constexpr uint32_t kPadding = 0xffffffffu;
// As in a built tree: squares of differences of such coordinates still fit in a float.
constexpr float kFarAway = 1e17f;

Sphere decodeSphere(const std::byte* p)
{
	return {loadF32(p), loadF32(p + 4), loadF32(p + 8), loadF32(p + 12)};
}

BallNode decodeNode(const std::byte* p)
{
	BallNode node;
	for (float* lane : {node.x, node.y, node.z, node.r})
		for (int i = 0; i < BallNode::kWidth; ++i, p += 4) lane[i] = loadF32(p);
	for (uint32_t& child : node.child)
	{
		child = loadU32(p);
		p += 4;
	}
	return node;
}

MomentEllipsoid decodeBall(const std::byte* p)
{
	MomentEllipsoid b;
	b.x = loadF32(p);
	b.y = loadF32(p + 4);
	b.z = loadF32(p + 8);
	b.R = loadF32(p + 12);
	b.density = loadF32(p + 16);
	b.nx = loadF32(p + 20);
	b.ny = loadF32(p + 24);
	b.nz = loadF32(p + 28);
	b.depth = loadF32(p + 32);
	b.sphere = loadU32(p + 36);
	p += 40;
	for (float* v : {&b.xx, &b.yy, &b.zz, &b.xy, &b.xz, &b.yz})
	{
		*v = loadF32(p);
		p += 4;
	}
	return b;
}

MomentEllipsoid padding()
{
	MomentEllipsoid b;
	b.x = b.y = b.z = kFarAway;
	return b;
}

BallBlock blockOf(const std::byte* head, const MomentEllipsoid* balls)
{
	BallBlock block;
	for (size_t k = 0; k < kWidth; ++k)
	{
		block.x[k] = balls[k].x;
		block.y[k] = balls[k].y;
		block.z[k] = balls[k].z;
		block.R[k] = balls[k].R;
	}
	block.count = loadU32(head);
	block.bx = loadF32(head + 4);
	block.by = loadF32(head + 8);
	block.bz = loadF32(head + 12);
	block.br = loadF32(head + 16);
	return block;
}

void writeTree(ByteWriter& w, const BallTree& tree, bool indicesOnly)
{
	w.reserve(16 + tree.nodes.size() * kNodeBytes + tree.blocks.size() * kHeadBytes + tree.balls.size() * kBallBytes);
	w.u64(tree.nodes.size());
	w.u64(tree.blocks.size());
	for (const BallNode& n : tree.nodes)
	{
		for (const float* lane : {n.x, n.y, n.z, n.r})
			for (int i = 0; i < BallNode::kWidth; ++i) w.f32(lane[i]);
		for (uint32_t child : n.child) w.u32(child);
	}
	for (const BallBlock& b : tree.blocks)
	{
		w.u32(b.count);
		for (float v : {b.bx, b.by, b.bz, b.br}) w.f32(v);
	}
	for (size_t i = 0; i < tree.balls.size(); ++i)
	{
		const MomentEllipsoid& b = tree.balls[i];
		if (indicesOnly)
		{
			w.u32(i % kWidth < tree.blocks[i / kWidth].count ? b.sphere : kPadding);
			continue;
		}
		for (float v : {b.x, b.y, b.z, b.R, b.density, b.nx, b.ny, b.nz, b.depth}) w.f32(v);
		w.u32(b.sphere);
		for (float v : {b.xx, b.yy, b.zz, b.xy, b.xz, b.yz}) w.f32(v);
	}
}

/// Where the parts of a tree section lie.
struct TreeBytes
{
	size_t nodeCount = 0, blockCount = 0;
	const std::byte *nodes = nullptr, *heads = nullptr, *balls = nullptr;

	bool find(ByteReader& r, size_t ballBytes)
	{
		nodeCount = r.count(kNodeBytes);
		blockCount = r.count(kHeadBytes + kWidth * ballBytes);
		nodes = r.span(nodeCount * kNodeBytes);
		heads = r.span(blockCount * kHeadBytes);
		balls = r.span(blockCount * kWidth * ballBytes);
		return r.complete();
	}
};

/// Fills balls and blocks together, each once, and looks at them while they are at hand. `ball(i)` gives the i-th of sixteen for
/// each block.
template <class Ball>
SectionState readTree(const TreeBytes& bytes, BallTree& tree, size_t sphereCount, Ball ball)
{
	reserveLarge(tree.nodes, bytes.nodeCount);
	reserveLarge(tree.blocks, bytes.blockCount);
	reserveLarge(tree.balls, bytes.blockCount * kWidth);
	for (size_t i = 0; i < bytes.nodeCount; ++i) tree.nodes.push_back(decodeNode(bytes.nodes + i * kNodeBytes));
	bool named = true, sure = true;
	for (size_t block = 0; block < bytes.blockCount; ++block)
	{
		MomentEllipsoid balls[kWidth];
		const std::byte* head = bytes.heads + block * kHeadBytes;
		// Padding is what it is, whatever the file says.
		const uint32_t real = loadU32(head);
		for (size_t k = 0; k < kWidth; ++k) balls[k] = k < real ? ball(block * kWidth + k) : padding();
		tree.blocks.push_back(blockOf(head, balls));
		const uint32_t count = tree.blocks.back().count;
		for (size_t k = 0; k < kWidth; ++k) named &= k >= count || balls[k].sphere < sphereCount;
		tree.balls.insert(tree.balls.end(), balls, balls + kWidth);
		sure &= surelyValid(tree.blocks.back(), balls);
	}
	if (!named) return SectionState::Bad;
	return sure && surelyValidNodes(tree) ? SectionState::Good : SectionState::Doubtful;
}

SectionState readMomentTree(ByteReader& r, BallTree& tree, size_t sphereCount)
{
	TreeBytes bytes;
	if (!bytes.find(r, kBallBytes)) return SectionState::Bad;
	return readTree(bytes, tree, sphereCount, [&](size_t i) { return decodeBall(bytes.balls + i * kBallBytes); });
}

/// Every sphere stands in the inner tree once, and padding nowhere but at the end of a block.
SectionState readInnerTree(ByteReader& r, BallTree& tree, const std::vector<Sphere>& spheres)
{
	TreeBytes bytes;
	if (!bytes.find(r, kIndexBytes)) return SectionState::Bad;
	std::vector<char> seen(spheres.size());
	size_t found = 0;
	const auto ball = [&](size_t i)
	{
		const uint32_t index = loadU32(bytes.balls + i * kIndexBytes);
		if (index < seen.size() && !seen[index])
		{
			seen[index] = 1;
			++found;
		}
		return index < spheres.size() ? ballOf(spheres[index], index) : padding();
	};
	const SectionState state = readTree(bytes, tree, spheres.size(), ball);
	return found == spheres.size() && tree.ballCount() == spheres.size() ? state : SectionState::Bad;
}

void writeSpheres(ByteWriter& w, const std::vector<Sphere>& spheres)
{
	w.u64(spheres.size());
	for (const Sphere& s : spheres)
		for (float v : {s.x, s.y, s.z, s.r}) w.f32(v);
}

void readSpheres(ByteReader& r, std::vector<Sphere>& spheres)
{
	const size_t count = r.count(kSphereBytes);
	const std::byte* bytes = r.span(count * kSphereBytes);
	if (!r.complete()) return;
	reserveLarge(spheres, count);
	for (size_t i = 0; i < count; ++i) spheres.push_back(decodeSphere(bytes + i * kSphereBytes));
}
}  // namespace

const char* sectionName(uint32_t id)
{
	static const char* const names[] = {"", "mass", "provenance", "sphere", "law tree", "cell tree", "inner tree"};
	return names[id];
}

void writeMass(ByteWriter& w, const InnerSphereTree& t)
{
	w.vec3(t.origin);
	w.f64(t.volume);
	for (int i = 0; i < 3; ++i) w.vec3(t.inertia.row(i));
	w.f64(t.area);
	w.vec3(t.box.lower);
	w.vec3(t.box.upper);
	for (double v : {t.meanGap, t.maxGap, t.uncoveredArea, t.fill}) w.f64(v);
}

void readMass(ByteReader& r, InnerSphereTree& t)
{
	t.origin = r.vec3();
	t.volume = r.f64();
	for (auto& row : t.inertia.m)
		for (double& v : row) v = r.f64();
	t.area = r.f64();
	t.box.lower = r.vec3();
	t.box.upper = r.vec3();
	for (double* v : {&t.meanGap, &t.maxGap, &t.uncoveredArea, &t.fill}) *v = r.f64();
}

void writeProvenance(ByteWriter& w, const InnerSphereTree::Provenance& p)
{
	w.u64(p.meshHash);
	w.f64(p.unit);
	w.f64(p.meshVolume);
	w.u8(p.watertight ? 1 : 0);
	w.text(p.repairMode);
	w.u64(p.repair.size());
	for (const std::string& line : p.repair) w.text(line);
	w.i64(p.requestedSpheres);
	w.f64(p.requestedFill);
	w.f64(p.requestedMinRadius);
	w.u64(p.seed);
}

void readProvenance(ByteReader& r, InnerSphereTree::Provenance& p)
{
	p.meshHash = r.u64();
	p.unit = r.f64();
	p.meshVolume = r.f64();
	const uint8_t watertight = r.u8();
	if (watertight > 1) r.fail();
	p.watertight = watertight != 0;
	p.repairMode = r.text();
	p.repair.resize(r.count(8));
	for (std::string& line : p.repair) line = r.text();
	p.requestedSpheres = r.i64();
	p.requestedFill = r.f64();
	p.requestedMinRadius = r.f64();
	p.seed = r.u64();
}

std::string describedViolation(const InnerSphereTree& tree)
{
	if (!isFinite(tree.box.lower) || !isFinite(tree.box.upper)) return "bounding box not finite";
	if (!std::isfinite(tree.provenance.unit) || !(tree.provenance.unit > 0)) return "unit not positive";
	return {};
}

std::vector<std::byte> encodeSection(uint32_t id, const InnerSphereTree& tree)
{
	ByteWriter w;
	switch (id)
	{
		case kMassSection: writeMass(w, tree); break;
		case kProvenanceSection: writeProvenance(w, tree.provenance); break;
		case kSphereSection: writeSpheres(w, tree.spheres); break;
		case kLawSection: writeTree(w, tree.law, false); break;
		case kCellSection: writeTree(w, tree.cells, false); break;
		default: writeTree(w, tree.inner, true); break;
	}
	return w.take();
}

SectionState decodeSection(uint32_t id, const std::byte* bytes, size_t size, InnerSphereTree& tree)
{
	ByteReader r(bytes, size);
	switch (id)
	{
		case kMassSection: readMass(r, tree); break;
		case kProvenanceSection: readProvenance(r, tree.provenance); break;
		case kSphereSection: readSpheres(r, tree.spheres); break;
		case kLawSection: return readMomentTree(r, tree.law, tree.spheres.size());
		case kCellSection: return readMomentTree(r, tree.cells, tree.spheres.size());
		default: return readInnerTree(r, tree.inner, tree.spheres);
	}
	return r.complete() ? SectionState::Good : SectionState::Bad;
}
}  // namespace ist
