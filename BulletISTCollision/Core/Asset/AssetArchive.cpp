// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Asset/AssetArchive.h"

#include "BulletISTCollision/Core/Asset/AssetSections.h"
#include "BulletISTCollision/Core/Asset/AtomicFile.h"
#include "BulletISTCollision/Core/Asset/Checksum.h"
#include "BulletISTCollision/Core/Asset/FloatCode.h"
#include "BulletISTCollision/Core/Base/AlignedBytes.h"

#include <numeric>
#include <span>

namespace ist
{
namespace
{
constexpr unsigned char kMagic[8] = {'I', 'S', 'T', 'A', 0x1a, '\r', 0x89, '\n'};
constexpr size_t kHeaderBytes = 8 + 4 + 4 + 8 + 8;  // magic, version, reserved 0, file size, checksum of what follows
constexpr int kGridBits = 21;
constexpr int kRadiusBits = 24;
constexpr uint32_t kGridMask = (1u << kGridBits) - 1;
// Bits of a leaf. Shapes are shares of the mean square radius, whose trace is 3, so five numbers are enough.
constexpr int kOffsetBits = 14, kLeafRadiusBits = 12, kVolumeBits = 11, kShapeBits = 8, kNormalBits = 10, kDepthBits = 12;
constexpr int kLeafBits = 3 * kOffsetBits + kLeafRadiusBits + kVolumeBits + 5 * kShapeBits + 3 * kNormalBits + kDepthBits;
constexpr double kOffsetLimit = (1 << (kOffsetBits - 1)) - 1, kDepthLimit = (1 << kDepthBits) - 1;
constexpr size_t kSphereBytes = 8 + 3 + 1;  // centre, radius, number of leaves (if below kManyLeaves)
constexpr uint8_t kManyLeaves = 255;        // the number follows as a u32

/// Scales of the rounded numbers.
struct Scales
{
	Vec3 lower;             ///< lower corner of the grid, tree frame [m]
	double gridStep = 1;    ///< [m]
	double offsetStep = 1;  ///< step of leaf centres, relative to the centre of their sphere [m]
	double normalLimit = 1;
	double depthLower = 0, depthStep = 1;
	FloatCode sphereRadius, leafRadius, leafVolume;

	void write(ByteWriter& w) const
	{
		w.vec3(lower);
		for (double v : {gridStep, offsetStep, normalLimit, depthLower, depthStep}) w.f64(v);
		sphereRadius.write(w);
		leafRadius.write(w);
		leafVolume.write(w);
	}
	bool read(ByteReader& r)
	{
		lower = r.vec3();
		for (double* v : {&gridStep, &offsetStep, &normalLimit, &depthLower, &depthStep}) *v = r.f64();
		const bool codes = sphereRadius.read(r, kRadiusBits) && leafRadius.read(r, kLeafRadiusBits) && leafVolume.read(r, kVolumeBits);
		// This limit keeps sums of squares of all decoded values finite in float.
		constexpr double kFarthest = 1e12;
		for (double v :
			{lower.x, lower.y, lower.z, gridStep * kGridMask, offsetStep * kOffsetLimit, normalLimit, depthLower, depthStep * kDepthLimit})
			if (!(std::fabs(v) < kFarthest)) return false;
		return codes && normalLimit < 1.001 && sphereRadius.decoded(kGridMask) < kFarthest &&
			leafRadius.decoded((1u << kLeafRadiusBits) - 1) < kFarthest;
	}

	Vec3 center(uint64_t code) const
	{
		const auto at = [&](int axis) {
			return static_cast<float>(lower[axis] + double(code >> (axis * kGridBits) & kGridMask) * gridStep);
		};
		return {at(0), at(1), at(2)};
	}
	uint64_t centerCode(const Vec3& c) const
	{
		uint64_t code = 0;
		for (int axis = 0; axis < 3; ++axis)
			code |= static_cast<uint64_t>(std::clamp(std::round((c[axis] - lower[axis]) / gridStep), 0.0, double(kGridMask)))
				<< (axis * kGridBits);
		return code;
	}
};

struct Contents
{
	std::vector<uint64_t> centers;
	std::vector<float> radii;                          ///< at most as large as the rounded centres allow
	std::vector<std::vector<MomentEllipsoid>> leaves;  ///< leaves of each sphere
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

/// Returns false if a sphere vanishes.
bool roundSpheres(std::span<const Sphere> spheres, Contents& contents)
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
		// The rounded ball lies inside the original one; the factors cover the rounding of this line.
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
	Range offset, normal, depth, radius, volume;
	normal.add(1e-6);
	offset.add(0);
	for (const MomentEllipsoid& b : tree.law.slots())
	{
		if (!(b.R > 0)) continue;
		contents.leaves[b.sphere].push_back(b);
		const Vec3 from = contents.scales.center(contents.centers[b.sphere]);
		for (int axis = 0; axis < 3; ++axis)
		{
			offset.add(std::fabs(b.center()[axis] - from[axis]));
			normal.add(std::fabs(b.normal()[axis]));
		}
		depth.add(b.depth);
		radius.add(b.meanRadius());
		volume.add(b.volume());
	}
	Scales& s = contents.scales;
	s.offsetStep = offset.high > 0 ? offset.high / kOffsetLimit : 1;
	s.normalLimit = normal.high;
	s.depthLower = depth.low;
	s.depthStep = depth.high > depth.low ? (depth.high - depth.low) / kDepthLimit : 1;
	s.leafRadius = FloatCode(static_cast<float>(radius.low), static_cast<float>(radius.high), kLeafRadiusBits);
	s.leafVolume = FloatCode(static_cast<float>(volume.low), static_cast<float>(volume.high), kVolumeBits);
}

/// Writes codes one behind the other, the lowest bit first.
class BitWriter
{
public:
	void write(uint32_t code, int bits)
	{
		for (int i = 0; i < bits; ++i, ++m_count)
		{
			if (m_count % 8 == 0) m_bytes.push_back(std::byte{0});
			m_bytes.back() |= std::byte(static_cast<unsigned char>((code >> i & 1) << m_count % 8));
		}
	}
	/// Steps of limit / (2^(bits - 1) - 1) about zero, so that zero is exact.
	void writeSigned(double v, double limit, int bits)
	{
		const double half = (1 << (bits - 1)) - 1;
		write(static_cast<uint32_t>(std::clamp(std::round(v / limit * half), -half, half) + half), bits);
	}
	const std::vector<std::byte>& bytes() const { return m_bytes; }

private:
	std::vector<std::byte> m_bytes;
	size_t m_count = 0;
};

class BitReader
{
public:
	explicit BitReader(const std::byte* bytes) : m_bytes(bytes) {}
	uint32_t read(int bits)
	{
		uint32_t code = 0;
		for (int i = 0; i < bits; ++i, ++m_at) code |= (std::to_integer<uint32_t>(m_bytes[m_at / 8]) >> m_at % 8 & 1) << i;
		return code;
	}
	double readSigned(double limit, int bits)
	{
		const double half = (1 << (bits - 1)) - 1;
		return (read(bits) - half) / half * limit;
	}

private:
	const std::byte* m_bytes;
	size_t m_at = 0;
};

constexpr double kLargestShare = 3, kLargestOffDiagonal = 1.5;  // limits for a positive definite matrix of trace 3

void writeLeaf(BitWriter& w, const MomentEllipsoid& b, const Vec3& from, const Scales& s)
{
	for (int axis = 0; axis < 3; ++axis) w.writeSigned(b.center()[axis] - from[axis], s.offsetStep * kOffsetLimit, kOffsetBits);
	for (int axis = 0; axis < 3; ++axis) w.writeSigned(b.normal()[axis], s.normalLimit, kNormalBits);
	w.write(static_cast<uint32_t>(std::clamp(std::round((b.depth - s.depthLower) / s.depthStep), 0.0, kDepthLimit)), kDepthBits);
	w.write(s.leafVolume.nearest(static_cast<float>(b.volume())), kVolumeBits);
	w.write(s.leafRadius.nearest(static_cast<float>(b.meanRadius())), kLeafRadiusBits);
	const SymmetricMatrix3 share = b.shape() * (3 / b.shape().trace());
	for (double v : {share.xx, share.yy})
		w.write(static_cast<uint32_t>(std::round(v / kLargestShare * ((1 << kShapeBits) - 1))), kShapeBits);
	for (double v : {share.xy, share.xz, share.yz}) w.writeSigned(v, kLargestOffDiagonal, kShapeBits);
}

MomentEllipsoid readLeaf(BitReader& r, const Vec3& from, const Scales& s, uint32_t sphere)
{
	Vec3 center = from, normal;
	for (int axis = 0; axis < 3; ++axis) center[axis] += r.readSigned(s.offsetStep * kOffsetLimit, kOffsetBits);
	for (int axis = 0; axis < 3; ++axis) normal[axis] = r.readSigned(s.normalLimit, kNormalBits);
	const double depth = s.depthLower + r.read(kDepthBits) * s.depthStep;
	const double volume = s.leafVolume.decoded(r.read(kVolumeBits)), radius = s.leafRadius.decoded(r.read(kLeafRadiusBits));
	SymmetricMatrix3 share;
	for (double* v : {&share.xx, &share.yy}) *v = r.read(kShapeBits) * kLargestShare / ((1 << kShapeBits) - 1);
	share.zz = std::max(0.0, 3 - share.xx - share.yy);
	for (double* v : {&share.xy, &share.xz, &share.yz}) *v = r.readSigned(kLargestOffDiagonal, kShapeBits);
	MomentEllipsoid leaf = momentEllipsoid(center, share * (radius * radius), volume);
	leaf.setNormal(normal);
	leaf.depth = static_cast<float>(depth);
	leaf.sphere = sphere;
	return leaf;
}

std::vector<std::byte> encodeContents(const InnerSphereTree& tree, const Contents& contents, double largestShrink)
{
	ByteWriter w;
	InnerSphereTree mass = tree;
	mass.meanGap += largestShrink;
	mass.maxGap += largestShrink;
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
	BitWriter leaves;
	for (size_t i = 0; i < contents.leaves.size(); ++i)
		for (const MomentEllipsoid& leaf : contents.leaves[i])
			writeLeaf(leaves, leaf, contents.scales.center(contents.centers[i]), contents.scales);
	w.append(leaves.bytes());
	w.append(encodeSection(kSurfaceSection, tree));
	return w.take();
}

Error damaged(const std::string& what) { return {"the archive is damaged: " + what + "; copy or pack it again"}; }

/// Checks the header and returns a reader for the body of the file.
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
	if (version < kArchiveVersion)
		return Error{"the archive is of format version " + std::to_string(version) +
			" of BulletHaptics 0.3 or older; rebuild it: ist build MESH -o FILE, then ist pack FILE -o ARCHIVE"};
	if (size < fileSize)
		return Error{"the archive is cut short: it has " + std::to_string(size) + " bytes of " + std::to_string(fileSize) +
			"; copy or pack it again"};
	if (size > fileSize) return damaged("bytes follow its end");
	if (checksum64(bytes + kHeaderBytes, size - kHeaderBytes) != stored) return damaged("checksum mismatch");
	return ByteReader(bytes + kHeaderBytes, size - kHeaderBytes);
}

bool readBalls(ByteReader& r, InnerSphereTree& tree, std::vector<MomentEllipsoid>& leaves, std::vector<MomentEllipsoid>& cells)
{
	Scales scales;
	if (!scales.read(r)) return false;
	const size_t count = r.count(kSphereBytes);
	std::vector<uint32_t> leafCount(count);
	std::vector<Sphere> spheres(count);
	size_t total = 0;
	for (size_t i = 0; i < count; ++i)
	{
		const Vec3 c = scales.center(r.u64());
		const float radius = scales.sphereRadius.decoded(static_cast<uint32_t>(r.low(3)));
		spheres[i] = {static_cast<float>(c.x), static_cast<float>(c.y), static_cast<float>(c.z), radius};
		leafCount[i] = r.u8();
		if (leafCount[i] == kManyLeaves) leafCount[i] = r.u32();
		total += leafCount[i];
	}
	if (total > SIZE_MAX / kLeafBits) return false;
	const size_t leafBytes = (total * kLeafBits + 7) / 8;
	const std::byte* const bits = r.span(leafBytes);
	if (r.failed()) return false;
	BitReader body(bits);
	leaves.reserve(total);
	std::vector<uint32_t> index;
	for (size_t i = 0; i < count; ++i)
	{
		const size_t first = leaves.size();
		for (uint32_t k = 0; k < leafCount[i]; ++k) leaves.push_back(readLeaf(body, spheres[i].center(), scales, static_cast<uint32_t>(i)));
		index.resize(leafCount[i]);
		std::iota(index.begin(), index.end(), static_cast<uint32_t>(first));
		if (leafCount[i] > 0) cells.push_back(merged(leaves.data(), index.data(), index.size()));
	}
	tree.spheres = std::move(spheres);
	return true;
}

/// Reads the surface section, which is the rest of the file. Its arrays lie in memory of their own.
bool readSurface(ByteReader& r, InnerSphereTree& tree)
{
	const size_t size = r.left();
	const std::byte* const bytes = r.span(size);
	const std::shared_ptr<std::byte> copy = makeAlignedBytes(size);
	if (!copy) return false;
	std::copy(bytes, bytes + size, copy.get());
	return decodeSection(kSurfaceSection, copy, copy.get(), size, tree) != SectionState::Bad;
}

bool usable(const std::vector<MomentEllipsoid>& balls)
{
	for (const MomentEllipsoid& b : balls)
		if (!isFinite(b.center()) || !std::isfinite(b.R) || !std::isfinite(b.density) || !b.isSolid()) return false;
	return !balls.empty();
}
}  // namespace

bool isArchive(const std::byte* bytes, size_t size) { return size >= sizeof kMagic && std::memcmp(bytes, kMagic, sizeof kMagic) == 0; }

Result<std::vector<std::byte>> encodeArchive(const InnerSphereTree& tree)
{
	Contents contents;
	if (!roundSpheres(tree.spheres, contents))
		return Error{"a sphere is too small beside the body to be archived: build it again with a larger BuildOptions::minRadius"};
	double largestShrink = 0;
	for (size_t i = 0; i < tree.spheres.size(); ++i)
	{
		const Sphere& s = tree.spheres[i];
		const FloatCode& code = contents.scales.sphereRadius;
		largestShrink = std::max(largestShrink,
			distance(contents.scales.center(contents.centers[i]), s.center()) + s.r - code.decoded(code.roundedDown(contents.radii[i])));
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
	std::vector<MomentEllipsoid> leaves, cells;
	if (!readBalls(body.value(), tree, leaves, cells) || !readSurface(body.value(), tree)) return damaged("it contradicts itself");
	for (const std::vector<MomentEllipsoid>* balls : {&leaves, &cells})
		if (!usable(*balls)) return damaged("a ball without mass");
	double sum = 0;
	for (const Sphere& s : tree.spheres) sum += kUnitBall * s.r * s.r * s.r;
	tree.fill = sum / tree.volume;
	tree.law = buildBallTree(leaves);
	tree.cells = buildBallTree(cells);
	tree.inner = buildInnerTree(tree.spheres);
	for (const std::string& problem : {describedViolation(tree), tree.validate()})
		if (!problem.empty()) return damaged(problem);
	return tree;
}

Result<size_t> saveArchive(const InnerSphereTree& tree, const std::string& path, const Progress& progress)
{
	const Result<std::vector<std::byte>> bytes = encodeArchive(tree);
	if (!bytes) return Error{"\"" + path + "\": " + bytes.error().message};
	return writeFileAtomically(path, bytes.value().data(), bytes.value().size(), progress);
}
}  // namespace ist
