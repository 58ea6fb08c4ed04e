// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/AssetArchive.h"

#include "BulletISTCollision/Core/AssetSections.h"
#include "BulletISTCollision/Core/Checksum.h"
#include "BulletISTCollision/Core/FloatCode.h"
#include "BulletISTCollision/Core/WholeFile.h"

#include <utility>

namespace ist
{
namespace
{
constexpr unsigned char kMagic[8] = {'I', 'S', 'T', 'A', 0x1a, '\r', 0x89, '\n'};
constexpr size_t kHeaderBytes = 8 + 4 + 4 + 8 + 8;  // magic, version, reserved 0, file size, checksum of what follows
constexpr int kGridBits = 21;
constexpr int kRadiusBits = 24, kLeafBits = 16;
constexpr uint32_t kGridMask = (1u << kGridBits) - 1;
constexpr double kOffsetLimit = 32767, kDepthLimit = 65535;
constexpr int kNormalBits[3] = {13, 13, 14};
constexpr size_t kSphereBytes = 8 + 3 + 1;  // centre, radius, number of leaves when below kManyLeaves
constexpr uint8_t kManyLeaves = 255;        // the number follows as a u32
constexpr size_t kLeafBytes = 6 + 2 + 2 + 5 + 2;  // offset, radius, mass, normal, depth
constexpr double kUnitBall = 4.18879020478639098462;

double massOf(const MomentBall& b)
{
	return b.density * kUnitBall * b.R * b.R * b.R;
}

/// How numbers were rounded.
struct Scales
{
	Vec3 lower;             ///< of the grid, tree frame [m]
	double gridStep = 1;    ///< [m]
	double offsetStep = 1;  ///< of leaves, from the centre of their sphere [m]
	double normalLimit = 1;
	double depthLower = 0, depthStep = 1;
	FloatCode sphereRadius, leafRadius, leafMass;

	void write(ByteWriter& w) const
	{
		w.vec3(lower);
		for (double v : {gridStep, offsetStep, normalLimit, depthLower, depthStep}) w.f64(v);
		sphereRadius.write(w);
		leafRadius.write(w);
		leafMass.write(w);
	}
	bool read(ByteReader& r)
	{
		lower = r.vec3();
		for (double* v : {&gridStep, &offsetStep, &normalLimit, &depthLower, &depthStep}) *v = r.f64();
		const bool codes = sphereRadius.read(r, kRadiusBits) && leafRadius.read(r, kLeafBits) && leafMass.read(r, kLeafBits);
		// Sums of squares of all that is decoded stay finite floats.
		constexpr double kFarthest = 1e12;
		for (double v : {lower.x, lower.y, lower.z, gridStep * kGridMask, offsetStep * kOffsetLimit, normalLimit, depthLower, depthStep * kDepthLimit})
			if (!(std::fabs(v) < kFarthest)) return false;
		return codes && sphereRadius.decoded(kGridMask) < kFarthest && leafRadius.decoded((1u << kLeafBits) - 1) < kFarthest;
	}

	Vec3 center(uint64_t code) const
	{
		const auto at = [&](int axis) { return static_cast<float>(lower[axis] + double(code >> (axis * kGridBits) & kGridMask) * gridStep); };
		return {at(0), at(1), at(2)};
	}
	uint64_t centerCode(const Vec3& c) const
	{
		uint64_t code = 0;
		for (int axis = 0; axis < 3; ++axis)
			code |= static_cast<uint64_t>(std::clamp(std::round((c[axis] - lower[axis]) / gridStep), 0.0, double(kGridMask))) << (axis * kGridBits);
		return code;
	}
};

struct Contents
{
	std::vector<uint64_t> centers;
	std::vector<float> radii;  ///< at most those allowed by the rounded centres
	std::vector<std::vector<MomentBall>> leaves;  ///< of each sphere
	Scales scales;
};

struct Range
{
	double low = HUGE_VAL, high = -HUGE_VAL;
	void add(double v)
	{
		low = std::min(low, v);
		high = std::max(high, v);
	}
};

/// False when a sphere vanishes.
bool roundSpheres(const std::vector<Sphere>& spheres, Contents& contents)
{
	Range axes[3];
	for (const Sphere& s : spheres)
		for (int axis = 0; axis < 3; ++axis) axes[axis].add(s.center()[axis]);
	Scales& scales = contents.scales;
	scales.lower = {axes[0].low, axes[1].low, axes[2].low};
	const double side = std::max({axes[0].high - axes[0].low, axes[1].high - axes[1].low, axes[2].high - axes[2].low});
	scales.gridStep = side > 0 ? side / kGridMask : 1;

	float smallest = HUGE_VALF, largest = 0;
	for (const Sphere& s : spheres)
	{
		const uint64_t code = scales.centerCode(s.center());
		// A ball inside the original one; the share covers the rounding of this line.
		const double room = s.r - distance(scales.center(code), s.center()) * (1 + 1e-9) - 1e-14 * s.r;
		if (!(room > 0)) return false;
		const float radius = std::nextafter(static_cast<float>(room), 0.0f);
		contents.centers.push_back(code);
		contents.radii.push_back(radius);
		smallest = std::min(smallest, radius);
		largest = std::max(largest, radius);
	}
	scales.sphereRadius = FloatCode(smallest, largest, kRadiusBits);
	return smallest > 0;
}

void collectLeaves(const InnerSphereTree& tree, Contents& contents)
{
	contents.leaves.resize(tree.spheres.size());
	Range offset, normal, depth, radius, mass;
	normal.add(1e-6);
	offset.add(0);
	for (size_t i = 0; i < tree.law.balls.size(); ++i)
	{
		if (i % BallBlock::kWidth >= tree.law.blocks[i / BallBlock::kWidth].count) continue;
		const MomentBall& b = tree.law.balls[i];
		contents.leaves[b.sphere].push_back(b);
		const Vec3 from = contents.scales.center(contents.centers[b.sphere]);
		for (int axis = 0; axis < 3; ++axis)
		{
			offset.add(std::fabs(b.center()[axis] - from[axis]));
			normal.add(std::fabs(b.normal()[axis]));
		}
		depth.add(b.depth);
		radius.add(b.R);
		mass.add(massOf(b));
	}
	Scales& s = contents.scales;
	s.offsetStep = offset.high > 0 ? offset.high / kOffsetLimit : 1;
	s.normalLimit = normal.high;
	s.depthLower = depth.low;
	s.depthStep = depth.high > depth.low ? (depth.high - depth.low) / kDepthLimit : 1;
	s.leafRadius = FloatCode(static_cast<float>(radius.low), static_cast<float>(radius.high), kLeafBits);
	s.leafMass = FloatCode(static_cast<float>(mass.low), static_cast<float>(mass.high), kLeafBits);
}

int16_t offsetCode(double offset, double step)
{
	return static_cast<int16_t>(std::clamp(std::round(offset / step), -kOffsetLimit, kOffsetLimit));
}

void writeLeaf(ByteWriter& w, const MomentBall& b, const Vec3& from, const Scales& s)
{
	for (int axis = 0; axis < 3; ++axis) w.u16(static_cast<uint16_t>(offsetCode(b.center()[axis] - from[axis], s.offsetStep)));
	w.u16(static_cast<uint16_t>(s.leafRadius.nearest(b.R)));
	w.u16(static_cast<uint16_t>(s.leafMass.nearest(static_cast<float>(massOf(b)))));
	uint64_t normal = 0;
	for (int axis = 0, shift = 0; axis < 3; shift += kNormalBits[axis++])
	{
		// An even number of steps about zero, so that zero is kept.
		const double half = (1 << (kNormalBits[axis] - 1)) - 1;
		normal |= static_cast<uint64_t>(std::clamp(std::round(b.normal()[axis] / s.normalLimit * half), -half, half) + half) << shift;
	}
	w.low(normal, 5);
	w.u16(static_cast<uint16_t>(std::clamp(std::round((b.depth - s.depthLower) / s.depthStep), 0.0, kDepthLimit)));
}

MomentBall readLeaf(ByteReader& r, const Vec3& from, const Scales& s, uint32_t sphere)
{
	MomentBall b;
	const auto coordinate = [&](double origin) { return static_cast<float>(origin + static_cast<int16_t>(r.u16()) * s.offsetStep); };
	b.x = coordinate(from.x);
	b.y = coordinate(from.y);
	b.z = coordinate(from.z);
	b.R = s.leafRadius.decoded(r.u16());
	b.density = static_cast<float>(s.leafMass.decoded(r.u16()) / (kUnitBall * b.R * b.R * b.R));
	const uint64_t normal = r.low(5);
	int shift = 0, axis = 0;
	for (float* component : {&b.nx, &b.ny, &b.nz})
	{
		const double half = (1 << (kNormalBits[axis] - 1)) - 1;
		*component = static_cast<float>((double(normal >> shift & ((1u << kNormalBits[axis]) - 1)) - half) / half * s.normalLimit);
		shift += kNormalBits[axis++];
	}
	b.depth = static_cast<float>(s.depthLower + r.u16() * s.depthStep);
	b.sphere = sphere;
	return b;
}

/// The parent of the pieces: masses add up, centroid, second moment, normal and depth are means by mass.
MomentBall merged(const MomentBall* pieces, size_t count)
{
	if (count == 1) return *pieces;
	double mass = 0, depth = 0, second = 0;
	Vec3 center, normal;
	for (size_t i = 0; i < count; ++i)
	{
		const double m = massOf(pieces[i]);
		mass += m;
		center += m * pieces[i].center();
		normal += m * pieces[i].normal();
		depth += m * pieces[i].depth;
	}
	center *= 1 / mass;
	for (size_t i = 0; i < count; ++i)
		second += massOf(pieces[i]) * (0.6 * pieces[i].R * pieces[i].R + squaredNorm(pieces[i].center() - center));
	MomentBall whole;
	whole.x = static_cast<float>(center.x);
	whole.y = static_cast<float>(center.y);
	whole.z = static_cast<float>(center.z);
	whole.R = static_cast<float>(std::sqrt(second / mass / 0.6));
	whole.density = static_cast<float>(mass / (kUnitBall * whole.R * whole.R * whole.R));
	whole.nx = static_cast<float>(normal.x / mass);
	whole.ny = static_cast<float>(normal.y / mass);
	whole.nz = static_cast<float>(normal.z / mass);
	whole.depth = static_cast<float>(depth / mass);
	whole.sphere = pieces->sphere;
	return whole;
}

std::vector<std::byte> encodeContents(const InnerSphereTree& tree, const Contents& contents, double largestShrink)
{
	ByteWriter w;
	InnerSphereTree mass;
	mass.origin = tree.origin;
	mass.volume = tree.volume;
	mass.inertia = tree.inertia;
	mass.area = tree.area;
	mass.box = tree.box;
	mass.meanGap = tree.meanGap + largestShrink;
	mass.maxGap = tree.maxGap + largestShrink;
	mass.uncoveredArea = tree.uncoveredArea;
	mass.fill = tree.fill;
	writeMass(w, mass);
	writeProvenance(w, tree.provenance);
	contents.scales.write(w);
	w.u64(contents.centers.size());
	for (size_t i = 0; i < contents.centers.size(); ++i)
	{
		w.u64(contents.centers[i]);
		w.low(contents.scales.sphereRadius.roundedDown(contents.radii[i]), 3);
		const size_t leaves = contents.leaves[i].size();
		w.u8(static_cast<uint8_t>(std::min<size_t>(leaves, kManyLeaves)));
		if (leaves >= kManyLeaves) w.u32(static_cast<uint32_t>(leaves));
	}
	for (size_t i = 0; i < contents.leaves.size(); ++i)
		for (const MomentBall& leaf : contents.leaves[i]) writeLeaf(w, leaf, contents.scales.center(contents.centers[i]), contents.scales);
	return w.take();
}

Error damaged(const std::string& what)
{
	return {"the archive is damaged: " + what + "; copy or pack it again"};
}

/// The checked body of the file.
Result<ByteReader> openBody(const std::byte* bytes, size_t size)
{
	if (size < kHeaderBytes) return Error{"the archive is cut short: it has " + std::to_string(size) + " bytes; copy or pack it again"};
	ByteReader r(bytes + sizeof kMagic, kHeaderBytes - sizeof kMagic);
	const uint32_t version = r.u32(), reserved = r.u32();
	const uint64_t fileSize = r.u64(), stored = r.u64();
	if (version > kArchiveVersion)
		return Error{"the archive was written by a newer version (" + std::to_string(version) + "), this library reads up to " +
					 std::to_string(kArchiveVersion) + "; pack it again or update the library"};
	if (version == 0 || reserved != 0) return damaged("its header is not one");
	if (size < fileSize)
		return Error{"the archive is cut short: it has " + std::to_string(size) + " bytes of " + std::to_string(fileSize) + "; copy or pack it again"};
	if (size > fileSize) return damaged("bytes follow its end");
	if (checksum64(bytes + kHeaderBytes, size - kHeaderBytes) != stored) return damaged("checksum mismatch");
	return ByteReader(bytes + kHeaderBytes, size - kHeaderBytes);
}

bool readBalls(ByteReader& r, InnerSphereTree& tree, std::vector<MomentBall>& leaves, std::vector<MomentBall>& cells)
{
	Scales scales;
	if (!scales.read(r)) return false;
	const size_t count = r.count(kSphereBytes);
	std::vector<uint32_t> leafCount(count);
	tree.spheres.resize(count);
	size_t total = 0;
	for (size_t i = 0; i < count; ++i)
	{
		const Vec3 c = scales.center(r.u64());
		const float radius = scales.sphereRadius.decoded(static_cast<uint32_t>(r.low(3)));
		tree.spheres[i] = {static_cast<float>(c.x), static_cast<float>(c.y), static_cast<float>(c.z), radius};
		leafCount[i] = r.u8();
		if (leafCount[i] == kManyLeaves) leafCount[i] = r.u32();
		total += leafCount[i];
	}
	ByteReader body(r.span(total * kLeafBytes), r.failed() ? 0 : total * kLeafBytes);
	if (!r.complete()) return false;
	leaves.reserve(total);
	for (size_t i = 0; i < count; ++i)
	{
		for (uint32_t k = 0; k < leafCount[i]; ++k)
			leaves.push_back(readLeaf(body, tree.spheres[i].center(), scales, static_cast<uint32_t>(i)));
		if (leafCount[i] > 0) cells.push_back(merged(leaves.data() + leaves.size() - leafCount[i], leafCount[i]));
	}
	return body.complete();
}

std::vector<MomentBall> innerBalls(const std::vector<Sphere>& spheres)
{
	std::vector<MomentBall> balls;
	balls.reserve(spheres.size());
	for (const Sphere& s : spheres) balls.push_back({s.x, s.y, s.z, s.r, 1, 0, 0, 0, 0, static_cast<uint32_t>(balls.size())});
	return balls;
}

bool usable(const std::vector<MomentBall>& balls)
{
	for (const MomentBall& b : balls)
		if (!isFinite(b.center()) || !std::isfinite(b.R) || !(b.R > 0) || !std::isfinite(b.density) || !(b.density > 0)) return false;
	return !balls.empty();
}
}  // namespace

bool isArchive(const std::byte* bytes, size_t size)
{
	return size >= sizeof kMagic && std::memcmp(bytes, kMagic, sizeof kMagic) == 0;
}

Result<std::vector<std::byte>> encodeArchive(const InnerSphereTree& tree)
{
	Contents contents;
	if (!roundSpheres(tree.spheres, contents))
		return Error{"a sphere is too small beside the body to be archived: build it again with a larger --min-radius"};
	double largestShrink = 0;
	for (size_t i = 0; i < tree.spheres.size(); ++i)
	{
		const Sphere& s = tree.spheres[i];
		const FloatCode& code = contents.scales.sphereRadius;
		largestShrink = std::max(largestShrink, distance(contents.scales.center(contents.centers[i]), s.center()) + s.r - code.decoded(code.roundedDown(contents.radii[i])));
	}
	collectLeaves(tree, contents);
	const std::vector<std::byte> body = encodeContents(tree, contents, largestShrink);
	ByteWriter file;
	for (unsigned char c : kMagic) file.u8(c);
	file.u32(kArchiveVersion);
	file.u32(0);
	file.u64(kHeaderBytes + body.size());
	file.u64(checksum64(body.data(), body.size()));
	file.append(body);
	return file.take();
}

Result<InnerSphereTree> decodeArchive(const std::byte* bytes, size_t size)
{
	Result<ByteReader> body = openBody(bytes, size);
	if (!body) return body.error();
	InnerSphereTree tree;
	readMass(body.value(), tree);
	readProvenance(body.value(), tree.provenance);
	std::vector<MomentBall> leaves, cells;
	if (!readBalls(body.value(), tree, leaves, cells)) return damaged("it contradicts itself");
	const std::vector<MomentBall> inner = innerBalls(tree.spheres);
	for (const std::vector<MomentBall>* balls : {&std::as_const(leaves), &std::as_const(cells), &inner})
		if (!usable(*balls)) return damaged("a ball without mass");
	double sum = 0;
	for (const Sphere& s : tree.spheres) sum += kUnitBall * s.r * s.r * s.r;
	tree.fill = sum / tree.volume;
	tree.law = buildBallTree(leaves);
	tree.cells = buildBallTree(cells);
	tree.inner = buildBallTree(inner);
	for (const std::string& problem : {describedViolation(tree), tree.validate()})
		if (!problem.empty()) return damaged(problem);
	return tree;
}

Result<size_t> saveArchive(const InnerSphereTree& tree, const std::string& path, const Progress& progress)
{
	const Result<std::vector<std::byte>> bytes = encodeArchive(tree);
	if (!bytes) return Error{"\"" + path + "\": " + bytes.error().message};
	return writeWholeFile(path, bytes.value().data(), bytes.value().size(), progress);
}
}  // namespace ist
