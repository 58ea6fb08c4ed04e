// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Asset/AssetSections.h"

#include "BulletISTCollision/Core/Tree/TreeCheck.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <type_traits>

namespace ist
{
namespace
{
/// Arrays of a file are used in place. Their elements are words of 32 or 16 bits, little endian, in exactly this order.
template <class T, size_t words>
constexpr bool isStored = std::is_trivially_copyable_v<T>&& std::is_standard_layout_v<T> && sizeof(T) == 4 * words &&
	alignof(T) <= kSectionAlignment;
static_assert(std::endian::native == std::endian::little, "assets are read in place: only for little-endian machines");
static_assert(isStored<Sphere, 4> && offsetof(Sphere, r) == 12);
static_assert(isStored<BallNode, 40> && offsetof(BallNode, r) == 96 && offsetof(BallNode, child) == 128);
static_assert(isStored<StoredEllipsoid, 8> && offsetof(StoredEllipsoid, depth) == 4 && offsetof(StoredEllipsoid, normal) == 8 &&
	offsetof(StoredEllipsoid, shape) == 16 && offsetof(StoredEllipsoid, sphere) == 28);
static_assert(isStored<SurfaceNode, 5> && offsetof(SurfaceNode, radius) == 12 && offsetof(SurfaceNode, child) == 16);
static_assert(isStored<SurfaceElement, 18> && offsetof(SurfaceElement, e1) == 12 && offsetof(SurfaceElement, e2) == 24 &&
	offsetof(SurfaceElement, normal) == 36 && offsetof(SurfaceElement, k11) == 48 && offsetof(SurfaceElement, area) == 60 &&
	offsetof(SurfaceElement, error) == 64 && offsetof(SurfaceElement, isTriangle) == 68);
static_assert(
	isStored<DepthNode, 6> && offsetof(DepthNode, offset) == 12 && offsetof(DepthNode, deepest) == 16 && offsetof(DepthNode, child) == 20);
static_assert(isStored<DepthCell, 15> && offsetof(DepthCell, depth) == 12 && offsetof(DepthCell, gradient) == 16 &&
	offsetof(DepthCell, hessian) == 28 && offsetof(DepthCell, error) == 52 && offsetof(DepthCell, radius) == 56);

template <class T> void writeArray(ByteWriter& w, const FrozenArray<T>& array)
{
	w.align(kSectionAlignment);
	w.append(reinterpret_cast<const std::byte*>(array.data()), array.size() * sizeof(T));
}

template <class T> FrozenArray<T> readArray(ByteReader& r, const std::shared_ptr<const void>& owner, size_t count)
{
	r.align(kSectionAlignment);
	const std::byte* bytes = r.span(count * sizeof(T));
	if (!bytes) return {};
	return {owner, reinterpret_cast<const T*>(bytes), count};
}

void writeTree(ByteWriter& w, const BallTree& tree)
{
	w.u64(tree.nodes.size());
	w.u64(tree.blockCount());
	writeArray(w, tree.nodes);
	writeArray(w, tree.balls);
	writeArray(w, tree.ellipsoids);
	writeArray(w, tree.sphereIndex);
}

/// Reads nodes and balls.
void readBounds(ByteReader& r, const std::shared_ptr<const void>& owner, BallTree& tree, size_t restOfBall)
{
	const size_t nodes = r.count(sizeof(BallNode)), blocks = r.count(kBlockWidth * (sizeof(Sphere) + restOfBall));
	tree.nodes = readArray<BallNode>(r, owner, nodes);
	tree.balls = readArray<Sphere>(r, owner, blocks * kBlockWidth);
}

/// Checks each block once; `accepts` is called for every slot that is not padding.
template <class Accepts> SectionState stateOf(const BallTree& tree, Accepts accepts)
{
	bool accepted = true, sure = true;
	for (size_t block = 0; block < tree.blockCount(); ++block)
	{
		const size_t first = block * kBlockWidth, end = first + tree.ballCount(block);
		for (size_t slot = first; slot < end; ++slot) accepted &= accepts(slot);
		sure &= surelyValid(tree, block);
	}
	if (!accepted) return SectionState::Bad;
	return sure && surelyValidNodes(tree) ? SectionState::Good : SectionState::Doubtful;
}

SectionState readMomentTree(ByteReader& r, const std::shared_ptr<const void>& owner, BallTree& tree, size_t sphereCount)
{
	readBounds(r, owner, tree, sizeof(StoredEllipsoid));
	tree.ellipsoids = readArray<StoredEllipsoid>(r, owner, tree.slotCount());
	if (!r.complete()) return SectionState::Bad;
	return stateOf(tree, [&](size_t slot) { return tree.ellipsoids[slot].sphere < sphereCount; });
}

/// Reads the inner tree, and checks that it contains every sphere once.
SectionState readInnerTree(ByteReader& r, const std::shared_ptr<const void>& owner, BallTree& tree, const FrozenArray<Sphere>& spheres)
{
	readBounds(r, owner, tree, sizeof(uint32_t));
	tree.sphereIndex = readArray<uint32_t>(r, owner, tree.slotCount());
	if (!r.complete()) return SectionState::Bad;
	std::vector<char> seen(spheres.size());
	size_t found = 0;
	const auto isNext = [&](size_t slot) {
		// Neighbours in space are not neighbours in the packing. Without this prefetch most of the time would be spent waiting for
		// memory.
		const size_t ahead = std::min(slot + 2 * kBlockWidth, tree.slotCount() - 1);
		__builtin_prefetch(spheres.data() + std::min<size_t>(tree.sphereIndex[ahead], spheres.size()));
		const uint32_t index = tree.sphereIndex[slot];
		if (index >= seen.size() || seen[index]) return false;
		seen[index] = 1;
		++found;
		return std::memcmp(&spheres[index], &tree.balls[slot], sizeof(Sphere)) == 0;
	};
	const SectionState state = stateOf(tree, isNext);
	return found == spheres.size() ? state : SectionState::Bad;
}

void writeSurface(ByteWriter& w, const BodySurface& body)
{
	if (body.empty()) return;
	const ContactSurface& surface = body.surface;
	const DepthField& field = body.field;
	for (const size_t count : {surface.nodes.size(), surface.elements.size(), field.nodes.size(), field.cells.size()}) w.u64(count);
	w.vec3(field.domain.lower);
	w.vec3(field.domain.upper);
	w.f64(field.margin);
	writeArray(w, surface.nodes);
	writeArray(w, surface.elements);
	writeArray(w, field.nodes);
	writeArray(w, field.cells);
}

/// Every surface that is read, from a file or from an archive, comes from here.
SectionState readSurface(ByteReader& r, const std::shared_ptr<const void>& owner, BodySurface& body)
{
	body = {};
	if (r.complete()) return SectionState::Good;
	ContactSurface& surface = body.surface;
	DepthField& field = body.field;
	const size_t surfaceNodes = r.count(sizeof(SurfaceNode)), elements = r.count(sizeof(SurfaceElement));
	const size_t fieldNodes = r.count(sizeof(DepthNode)), cells = r.count(sizeof(DepthCell));
	field.domain.lower = r.vec3();
	field.domain.upper = r.vec3();
	field.margin = r.f64();
	surface.nodes = readArray<SurfaceNode>(r, owner, surfaceNodes);
	surface.elements = readArray<SurfaceElement>(r, owner, elements);
	field.nodes = readArray<DepthNode>(r, owner, fieldNodes);
	field.cells = readArray<DepthCell>(r, owner, cells);
	if (!r.complete() || body.empty()) return SectionState::Bad;
	if (!surface.validate().empty() || !field.validate().empty()) return SectionState::Doubtful;
	body.tables = buildQueryTables(surface, field);
	return SectionState::Good;
}
}  // namespace

const char* sectionName(uint32_t id)
{
	static const char* const names[] = {"", "mass", "provenance", "sphere", "law tree", "cell tree", "inner tree", "surface"};
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
	for (double v : {t.meanGap, t.maxGap, t.uncoveredArea, t.fill, t.resolution, t.sagitta}) w.f64(v);
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
	for (double* v : {&t.meanGap, &t.maxGap, &t.uncoveredArea, &t.fill, &t.resolution, &t.sagitta}) *v = r.f64();
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
	case kMassSection:
		writeMass(w, tree);
		w.u64(tree.calibration.size());
		for (double c : tree.calibration) w.f64(c);
		break;
	case kProvenanceSection: writeProvenance(w, tree.provenance); break;
	case kSphereSection:
		w.u64(tree.spheres.size());
		writeArray(w, tree.spheres);
		break;
	case kLawSection: writeTree(w, tree.law); break;
	case kCellSection: writeTree(w, tree.cells); break;
	case kInnerSection: writeTree(w, tree.inner); break;
	default: writeSurface(w, tree.surface); break;
	}
	return w.take();
}

SectionState decodeSection(
	uint32_t id, const std::shared_ptr<const void>& owner, const std::byte* bytes, size_t size, InnerSphereTree& tree)
{
	ByteReader r(bytes, size);
	switch (id)
	{
	case kMassSection:
		readMass(r, tree);
		tree.calibration.resize(r.count(8));
		for (double& c : tree.calibration) c = r.f64();
		break;
	case kProvenanceSection: readProvenance(r, tree.provenance); break;
	case kSphereSection: tree.spheres = readArray<Sphere>(r, owner, r.count(sizeof(Sphere))); break;
	case kLawSection: return readMomentTree(r, owner, tree.law, tree.spheres.size());
	case kCellSection: return readMomentTree(r, owner, tree.cells, tree.spheres.size());
	case kInnerSection: return readInnerTree(r, owner, tree.inner, tree.spheres);
	default: return readSurface(r, owner, tree.surface);
	}
	return r.complete() ? SectionState::Good : SectionState::Bad;
}
}  // namespace ist
