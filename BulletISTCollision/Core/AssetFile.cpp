// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/AssetFile.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <unistd.h>

namespace ist
{
namespace
{
// The line ends and the 0x1a catch a transfer in text mode.
constexpr unsigned char kMagic[8] = {'I', 'S', 'T', 0x1a, '\r', '\n', 0x89, '\n'};
constexpr size_t kHeaderBytes = 8 + 4 + 4 + 8 + 8;  // magic, version, section count, file size, checksum of header and table
constexpr size_t kChecksumOffset = 24;
constexpr size_t kTableEntryBytes = 4 + 4 + 8 + 8 + 8;  // id, reserved 0, offset, size, checksum

enum SectionId : uint32_t
{
	kMassSection = 1,
	kProvenanceSection,
	kSphereSection,
	kLawSection,
	kCellSection,
	kInnerSection,
	kSectionEnd
};
constexpr uint32_t kSectionCount = kSectionEnd - 1;

constexpr size_t kNodeBytes = BallNode::kWidth * 5 * 4;
constexpr size_t kBlockBytes = BallBlock::kWidth * 4 * 4 + 5 * 4;
constexpr size_t kBallBytes = 10 * 4;
constexpr size_t kSphereBytes = 4 * 4;

/// FNV-1a, 64 bit. Each step is a bijection of the state, so that any change confined to one byte is certain to be seen.
class Checksum
{
public:
	void add(const std::byte* bytes, size_t size)
	{
		for (size_t i = 0; i < size; ++i) m_state = (m_state ^ static_cast<uint64_t>(bytes[i])) * 0x100000001b3ull;
	}
	uint64_t value() const { return m_state; }

private:
	uint64_t m_state = 0xcbf29ce484222325ull;
};

uint64_t checksum(const std::byte* bytes, size_t size)
{
	Checksum sum;
	sum.add(bytes, size);
	return sum.value();
}

class Writer
{
public:
	void u8(uint8_t v) { m_bytes.push_back(static_cast<std::byte>(v)); }
	void u32(uint32_t v) { put(v, 4); }
	void u64(uint64_t v) { put(v, 8); }
	void i64(int64_t v) { u64(static_cast<uint64_t>(v)); }
	void f32(float v) { u32(std::bit_cast<uint32_t>(v)); }
	void f64(double v) { u64(std::bit_cast<uint64_t>(v)); }
	void vec3(const Vec3& v)
	{
		f64(v.x);
		f64(v.y);
		f64(v.z);
	}
	void text(const std::string& s)
	{
		u64(s.size());
		for (char c : s) u8(static_cast<uint8_t>(c));
	}
	void append(const std::vector<std::byte>& bytes) { m_bytes.insert(m_bytes.end(), bytes.begin(), bytes.end()); }
	const std::vector<std::byte>& bytes() const { return m_bytes; }
	std::vector<std::byte> take() { return std::move(m_bytes); }

private:
	void put(uint64_t v, int count)
	{
		std::byte raw[8];
		for (int i = 0; i < count; ++i) raw[i] = static_cast<std::byte>(v >> (8 * i));
		m_bytes.insert(m_bytes.end(), raw, raw + count);
	}
	std::vector<std::byte> m_bytes;
};

/// Reads past the end give zeros and set `failed`.
class Reader
{
public:
	Reader(const std::byte* bytes, size_t size) : m_bytes(bytes), m_left(size) {}

	uint8_t u8() { return static_cast<uint8_t>(get(1)); }
	uint32_t u32() { return static_cast<uint32_t>(get(4)); }
	uint64_t u64() { return get(8); }
	int64_t i64() { return static_cast<int64_t>(get(8)); }
	float f32() { return std::bit_cast<float>(u32()); }
	double f64() { return std::bit_cast<double>(u64()); }
	Vec3 vec3()
	{
		const double x = f64(), y = f64(), z = f64();
		return {x, y, z};
	}
	/// A count of things of at least `stride` bytes each: never more than the remaining bytes can hold.
	size_t count(size_t stride)
	{
		const uint64_t n = u64();
		if (n <= m_left / stride) return static_cast<size_t>(n);
		fail();
		return 0;
	}
	std::string text()
	{
		const size_t n = count(1);
		std::string s(reinterpret_cast<const char*>(m_bytes), n);
		m_bytes += n;
		m_left -= n;
		return s;
	}
	void fail()
	{
		m_failed = true;
		m_left = 0;
	}
	bool complete() const { return !m_failed && m_left == 0; }

private:
	uint64_t get(size_t n)
	{
		if (n > m_left)
		{
			fail();
			return 0;
		}
		uint64_t v = 0;
		for (size_t i = 0; i < n; ++i) v |= static_cast<uint64_t>(m_bytes[i]) << (8 * i);
		m_bytes += n;
		m_left -= n;
		return v;
	}
	const std::byte* m_bytes;
	size_t m_left;
	bool m_failed = false;
};

void writeMass(Writer& w, const InnerSphereTree& t)
{
	w.vec3(t.origin);
	w.f64(t.volume);
	for (int i = 0; i < 3; ++i) w.vec3(t.inertia.row(i));
	w.f64(t.area);
	w.vec3(t.box.lower);
	w.vec3(t.box.upper);
	for (double v : {t.meanGap, t.maxGap, t.uncoveredArea, t.fill}) w.f64(v);
}

void readMass(Reader& r, InnerSphereTree& t)
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

void writeProvenance(Writer& w, const InnerSphereTree::Provenance& p)
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

void readProvenance(Reader& r, InnerSphereTree::Provenance& p)
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

void writeSpheres(Writer& w, const std::vector<Sphere>& spheres)
{
	w.u64(spheres.size());
	for (const Sphere& s : spheres)
		for (float v : {s.x, s.y, s.z, s.r}) w.f32(v);
}

void readSpheres(Reader& r, std::vector<Sphere>& spheres)
{
	spheres.resize(r.count(kSphereBytes));
	for (Sphere& s : spheres)
		for (float* v : {&s.x, &s.y, &s.z, &s.r}) *v = r.f32();
}

void writeTree(Writer& w, const BallTree& tree)
{
	w.u64(tree.nodes.size());
	for (const BallNode& n : tree.nodes)
	{
		for (const float* lane : {n.x, n.y, n.z, n.r})
			for (int i = 0; i < BallNode::kWidth; ++i) w.f32(lane[i]);
		for (uint32_t child : n.child) w.u32(child);
	}
	w.u64(tree.blocks.size());
	for (const BallBlock& b : tree.blocks)
	{
		for (const float* lane : {b.x, b.y, b.z, b.R})
			for (int i = 0; i < BallBlock::kWidth; ++i) w.f32(lane[i]);
		w.u32(b.count);
		for (float v : {b.bx, b.by, b.bz, b.br}) w.f32(v);
	}
	w.u64(tree.balls.size());
	for (const MomentBall& b : tree.balls)
	{
		for (float v : {b.x, b.y, b.z, b.R, b.density, b.nx, b.ny, b.nz, b.depth}) w.f32(v);
		w.u32(b.sphere);
	}
}

void readTree(Reader& r, BallTree& tree)
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
	for (MomentBall& b : tree.balls)
	{
		for (float* v : {&b.x, &b.y, &b.z, &b.R, &b.density, &b.nx, &b.ny, &b.nz, &b.depth}) *v = r.f32();
		b.sphere = r.u32();
	}
}

const char* sectionName(uint32_t id)
{
	static const char* const names[] = {"", "mass", "provenance", "sphere", "law tree", "cell tree", "inner tree"};
	return names[id];
}

std::vector<std::byte> encodeSection(uint32_t id, const InnerSphereTree& tree)
{
	Writer w;
	switch (id)
	{
		case kMassSection: writeMass(w, tree); break;
		case kProvenanceSection: writeProvenance(w, tree.provenance); break;
		case kSphereSection: writeSpheres(w, tree.spheres); break;
		case kLawSection: writeTree(w, tree.law); break;
		case kCellSection: writeTree(w, tree.cells); break;
		default: writeTree(w, tree.inner); break;
	}
	return w.take();
}

bool decodeSection(uint32_t id, const std::byte* bytes, size_t size, InnerSphereTree& tree)
{
	Reader r(bytes, size);
	switch (id)
	{
		case kMassSection: readMass(r, tree); break;
		case kProvenanceSection: readProvenance(r, tree.provenance); break;
		case kSphereSection: readSpheres(r, tree.spheres); break;
		case kLawSection: readTree(r, tree.law); break;
		case kCellSection: readTree(r, tree.cells); break;
		default: readTree(r, tree.inner); break;
	}
	return r.complete();
}

uint64_t headerChecksum(const std::byte* bytes, size_t tableEnd)
{
	Checksum sum;
	sum.add(bytes, kChecksumOffset);
	sum.add(bytes + kHeaderBytes, tableEnd - kHeaderBytes);
	return sum.value();
}

Error cutShort(size_t have, uint64_t want)
{
	return {"the file is cut short: it has " + std::to_string(have) + " bytes of at least " + std::to_string(want) +
			"; copy or build it again"};
}

Error damaged(const std::string& what)
{
	return {"the file is damaged: " + what + "; copy or build it again"};
}

/// Magic, version, section count, table and file size. An empty message when all are as they should be.
Error checkHeader(const std::byte* bytes, size_t size)
{
	if (std::memcmp(bytes, kMagic, std::min(size, sizeof kMagic)) != 0) return {"this is not an inner sphere tree (.ist) file"};
	if (size < kHeaderBytes) return cutShort(size, kHeaderBytes);
	Reader r(bytes + sizeof kMagic, kHeaderBytes - sizeof kMagic);
	const uint32_t version = r.u32();
	if (version > kAssetVersion)
		return {"written by a newer version (" + std::to_string(version) + "), this library reads up to " +
				std::to_string(kAssetVersion) + "; build the file again or update the library"};
	if (version < kAssetVersion) return damaged("there is no version " + std::to_string(version));
	const uint32_t count = r.u32();
	const uint64_t fileSize = r.u64();
	const uint64_t stored = r.u64();
	if (count != kSectionCount) return damaged("wrong number of sections (" + std::to_string(count) + ")");
	constexpr size_t tableEnd = kHeaderBytes + kSectionCount * kTableEntryBytes;
	if (size < tableEnd) return cutShort(size, tableEnd);
	if (headerChecksum(bytes, tableEnd) != stored) return damaged("checksum mismatch in the header");
	if (size < fileSize) return cutShort(size, fileSize);
	if (size > fileSize) return damaged(std::to_string(size - fileSize) + " bytes follow its end");
	return {};
}

Error withPath(const std::string& path, const std::string& message)
{
	return {"\"" + path + "\": " + message};
}

Error systemError(const std::string& path, const char* doing)
{
	return withPath(path, std::string(doing) + " failed: " + std::strerror(errno));
}

bool writeAll(int file, const std::vector<std::byte>& bytes)
{
	for (size_t done = 0; done < bytes.size();)
	{
		const ssize_t n = ::write(file, bytes.data() + done, bytes.size() - done);
		if (n < 0 && errno == EINTR) continue;
		if (n <= 0) return false;
		done += static_cast<size_t>(n);
	}
	return true;
}
}  // namespace

std::vector<std::byte> encodeAsset(const InnerSphereTree& tree)
{
	Writer table, body;
	const size_t bodyStart = kHeaderBytes + kSectionCount * kTableEntryBytes;
	for (uint32_t id = 1; id < kSectionEnd; ++id)
	{
		const std::vector<std::byte> section = encodeSection(id, tree);
		table.u32(id);
		table.u32(0);
		table.u64(bodyStart + body.bytes().size());
		table.u64(section.size());
		table.u64(checksum(section.data(), section.size()));
		body.append(section);
	}
	Writer file;
	for (unsigned char c : kMagic) file.u8(c);
	file.u32(kAssetVersion);
	file.u32(kSectionCount);
	file.u64(bodyStart + body.bytes().size());
	Checksum sum;
	sum.add(file.bytes().data(), file.bytes().size());
	sum.add(table.bytes().data(), table.bytes().size());
	file.u64(sum.value());
	file.append(table.bytes());
	file.append(body.bytes());
	return file.take();
}

Result<InnerSphereTree> decodeAsset(const std::byte* bytes, size_t size)
{
	if (const Error error = checkHeader(bytes, size); !error.message.empty()) return error;
	InnerSphereTree tree;
	Reader table(bytes + kHeaderBytes, kSectionCount * kTableEntryBytes);
	uint64_t expected = kHeaderBytes + kSectionCount * kTableEntryBytes;
	for (uint32_t id = 1; id < kSectionEnd; ++id)
	{
		const std::string name = std::string("the ") + sectionName(id) + " section";
		const uint32_t storedId = table.u32(), reserved = table.u32();
		const uint64_t offset = table.u64(), length = table.u64(), stored = table.u64();
		if (storedId != id || reserved != 0 || offset != expected || length > size - offset)
			return damaged(name + " is not where it should be");
		if (checksum(bytes + offset, length) != stored) return damaged("checksum mismatch in " + name);
		if (!decodeSection(id, bytes + offset, length, tree)) return damaged(name + " does not have the size that it states");
		expected += length;
	}
	if (expected != size) return damaged("its sections do not fill it");
	if (const std::string problem = tree.validate(); !problem.empty()) return damaged(problem);
	return tree;
}

Result<size_t> saveAsset(const InnerSphereTree& tree, const std::string& path)
{
	const std::vector<std::byte> bytes = encodeAsset(tree);
	const std::string temporary = path + ".tmp" + std::to_string(::getpid());
	const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
	if (file < 0) return systemError(path, "creating the file");
	bool good = writeAll(file, bytes) && ::fsync(file) == 0;
	int reason = errno;
	if (::close(file) != 0 && good)
	{
		good = false;
		reason = errno;
	}
	if (good && ::rename(temporary.c_str(), path.c_str()) == 0) return bytes.size();
	if (good) reason = errno;
	::unlink(temporary.c_str());
	errno = reason;
	return systemError(path, "writing the file");
}

Result<InnerSphereTree> loadAsset(const std::string& path)
{
	std::ifstream stream(path, std::ios::binary | std::ios::ate);
	const std::streamoff size = stream ? static_cast<std::streamoff>(stream.tellg()) : -1;
	// A directory opens on some systems and then states a nonsensical size.
	if (size < 0 || size > std::streamoff(1) << 40) return withPath(path, "cannot be opened for reading");
	std::vector<std::byte> bytes(static_cast<size_t>(size));
	stream.seekg(0);
	if (!stream.read(reinterpret_cast<char*>(bytes.data()), size)) return withPath(path, "cannot be read");
	Result<InnerSphereTree> tree = decodeAsset(bytes.data(), bytes.size());
	if (!tree) return withPath(path, tree.error().message);
	return tree;
}
}  // namespace ist
