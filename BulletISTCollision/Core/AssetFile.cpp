// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/AssetFile.h"

#include "BulletISTCollision/Core/AssetArchive.h"
#include "BulletISTCollision/Core/AssetSections.h"
#include "BulletISTCollision/Core/Checksum.h"
#include "BulletISTCollision/Core/SurfaceResolution.h"
#include "BulletISTCollision/Core/WholeFile.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace ist
{
namespace
{
// The line ends and the 0x1a catch a transfer in text mode.
constexpr unsigned char kMagic[8] = {'I', 'S', 'T', 0x1a, '\r', '\n', 0x89, '\n'};
constexpr size_t kHeaderBytes = 8 + 4 + 4 + 8 + 8;  // magic, version, section count, file size, checksum of header and table
constexpr size_t kChecksumOffset = 24;
constexpr size_t kTableEntryBytes = 4 + 4 + 8 + 8 + 8;  // id, reserved 0, offset, size, checksum
constexpr uint32_t kSectionCount = kSectionEnd - 1;
constexpr size_t kBodyStart = kHeaderBytes + kSectionCount * kTableEntryBytes;
constexpr uint32_t kOldestVersion = 1;

/// FNV-1a, 64 bit: the checksum of version 1.
uint64_t checksumVersion1(const std::byte* bytes, size_t size)
{
	uint64_t sum = 0xcbf29ce484222325ull;
	for (size_t i = 0; i < size; ++i) sum = (sum ^ static_cast<uint64_t>(bytes[i])) * 0x100000001b3ull;
	return sum;
}

uint64_t checksum(uint32_t version, const std::byte* bytes, size_t size)
{
	return version == 1 ? checksumVersion1(bytes, size) : checksum64(bytes, size);
}

/// Of the header up to its checksum and the table behind it.
uint64_t headerChecksum(uint32_t version, const std::byte* bytes)
{
	std::vector<std::byte> covered(bytes, bytes + kChecksumOffset);
	covered.insert(covered.end(), bytes + kHeaderBytes, bytes + kBodyStart);
	return checksum(version, covered.data(), covered.size());
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
Error checkHeader(const std::byte* bytes, size_t size, uint32_t& version)
{
	if (size > 0 && std::memcmp(bytes, kMagic, std::min(size, sizeof kMagic)) != 0) return {"this is not an inner sphere tree (.ist) file"};
	if (size < kHeaderBytes) return cutShort(size, kHeaderBytes);
	ByteReader r(bytes + sizeof kMagic, kHeaderBytes - sizeof kMagic);
	version = r.u32();
	if (version > kAssetVersion)
		return {"written by a newer version (" + std::to_string(version) + "), this library reads up to " +
				std::to_string(kAssetVersion) + "; build the file again or update the library"};
	if (version < kOldestVersion) return damaged("there is no version " + std::to_string(version));
	const uint32_t count = r.u32();
	const uint64_t fileSize = r.u64();
	const uint64_t stored = r.u64();
	if (count != kSectionCount) return damaged("wrong number of sections (" + std::to_string(count) + ")");
	if (size < kBodyStart) return cutShort(size, kBodyStart);
	if (headerChecksum(version, bytes) != stored) return damaged("checksum mismatch in the header");
	if (size < fileSize) return cutShort(size, fileSize);
	if (size > fileSize) return damaged(std::to_string(size - fileSize) + " bytes follow its end");
	return {};
}

struct Section
{
	uint32_t id = 0;
	const std::byte* bytes = nullptr;
	size_t size = 0;
	uint64_t checksum = 0;
	SectionState state = SectionState::Bad;
	std::string problem;  ///< of a bad one
};

Error readTable(const std::byte* bytes, size_t size, std::vector<Section>& sections)
{
	ByteReader table(bytes + kHeaderBytes, kSectionCount * kTableEntryBytes);
	uint64_t expected = kBodyStart;
	for (uint32_t id = 1; id < kSectionEnd; ++id)
	{
		const uint32_t storedId = table.u32(), reserved = table.u32();
		const uint64_t offset = table.u64(), length = table.u64(), stored = table.u64();
		if (storedId != id || reserved != 0 || offset != expected || length > size - offset)
			return damaged(std::string("the ") + sectionName(id) + " section is not where it should be");
		sections.push_back({id, bytes + offset, static_cast<size_t>(length), stored, SectionState::Bad, {}});
		expected += length;
	}
	return expected == size ? Error{} : damaged("its sections do not fill it");
}

void readSection(uint32_t version, Section& section, InnerSphereTree& tree)
{
	if (checksum(version, section.bytes, section.size) != section.checksum)
	{
		section.problem = std::string("checksum mismatch in the ") + sectionName(section.id) + " section";
		return;
	}
	const auto decode = version == 1 ? decodeSectionVersion1 : decodeSection;
	section.state = decode(section.id, section.bytes, section.size, tree);
	if (section.state == SectionState::Bad) section.problem = std::string("the ") + sectionName(section.id) + " section contradicts itself";
}

bool isLength(double value)
{
	return std::isfinite(value) && value >= 0;
}

/// Quick answer to whether the mass section is as `InnerSphereTree::validate` wants it.
bool massHolds(const InnerSphereTree& tree)
{
	for (int i = 0; i < 3; ++i)
		if (!isFinite(tree.inertia.row(i))) return false;
	for (double length : {tree.volume, tree.area, tree.meanGap, tree.maxGap, tree.uncoveredArea, tree.fill})
		if (!isLength(length)) return false;
	return isFinite(tree.origin) && tree.volume > 0;
}

std::string readSections(uint32_t version, std::vector<Section>& sections, InnerSphereTree& tree)
{
	const int trees = kLawSection - 1, end = kSectionEnd - 1;
	for (int i = 0; i < trees; ++i)
	{
		readSection(version, sections[i], tree);
		if (!sections[i].problem.empty()) return sections[i].problem;
	}
	// Each in memory of its own; the largest first.
	[[maybe_unused]] const bool large = tree.spheres.size() > 10000;
#pragma omp parallel for schedule(dynamic, 1) if (large)
	for (int i = trees; i < end; ++i) readSection(version, sections[i], tree);
	bool doubtful = !massHolds(tree);
	for (const Section& section : sections)
	{
		if (!section.problem.empty()) return section.problem;
		doubtful |= section.state != SectionState::Good;
	}
	if (const std::string problem = describedViolation(tree); !problem.empty()) return problem;
	return doubtful ? tree.validate() : std::string();
}
}  // namespace

std::vector<std::byte> encodeAsset(const InnerSphereTree& tree)
{
	ByteWriter table, body;
	for (uint32_t id = 1; id < kSectionEnd; ++id)
	{
		const std::vector<std::byte> section = encodeSection(id, tree);
		table.u32(id);
		table.u32(0);
		table.u64(kBodyStart + body.size());
		table.u64(section.size());
		table.u64(checksum64(section.data(), section.size()));
		body.append(section);
	}
	ByteWriter file;
	for (unsigned char c : kMagic) file.u8(c);
	file.u32(kAssetVersion);
	file.u32(kSectionCount);
	file.u64(kBodyStart + body.size());
	ByteWriter covered;
	covered.append(file.bytes());
	covered.append(table.bytes());
	file.u64(checksum64(covered.bytes().data(), covered.size()));
	file.append(table.bytes());
	file.append(body.bytes());
	return file.take();
}

Result<InnerSphereTree> decodeAsset(const std::byte* bytes, size_t size)
{
	if (isArchive(bytes, size)) return decodeArchive(bytes, size);
	uint32_t version = 0;
	if (const Error error = checkHeader(bytes, size, version); !error.message.empty()) return error;
	std::vector<Section> sections;
	if (const Error error = readTable(bytes, size, sections); !error.message.empty()) return error;
	InnerSphereTree tree;
	if (const std::string problem = readSections(version, sections, tree); !problem.empty()) return damaged(problem);
	tree.resolution = surfaceResolution(tree.law);
	return tree;
}

Result<size_t> saveAsset(const InnerSphereTree& tree, const std::string& path, const Progress& progress)
{
	const std::vector<std::byte> bytes = encodeAsset(tree);
	return writeWholeFile(path, bytes.data(), bytes.size(), progress);
}

Result<InnerSphereTree> loadAsset(const std::string& path)
{
	const Result<MappedFile> file = MappedFile::open(path);
	if (!file) return file.error();
	Result<InnerSphereTree> tree = decodeAsset(file.value().bytes(), file.value().size());
	if (!tree) return Error{"\"" + path + "\": " + tree.error().message};
	return tree;
}
}  // namespace ist
