// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Asset/AssetFile.h"

#include "BulletISTCollision/Core/Asset/AssetArchive.h"
#include "BulletISTCollision/Core/Asset/AssetSections.h"
#include "BulletISTCollision/Core/Asset/AtomicFile.h"
#include "BulletISTCollision/Core/Asset/Checksum.h"
#include "BulletISTCollision/Core/Base/AlignedBytes.h"
#include "BulletISTCollision/Core/Platform/MappedFile.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace ist
{
namespace
{
// The line ends and the 0x1a detect a transfer in text mode.
constexpr unsigned char kMagic[8] = {'I', 'S', 'T', 0x1a, '\r', '\n', 0x89, '\n'};
constexpr size_t kHeaderBytes = 8 + 4 + 4 + 8 + 8;  // magic, version, section count, file size, checksum of header and table
constexpr size_t kChecksumOffset = 24;
constexpr size_t kTableEntryBytes = 4 + 4 + 8 + 8 + 8;  // id, reserved 0, offset, size, checksum
constexpr uint32_t kSectionCount = kSectionEnd - 1;
constexpr const char* kLastOfOlderFormats = "0.3";  // last release that wrote format version 6
constexpr size_t kTableEnd = kHeaderBytes + kSectionCount * kTableEntryBytes;

size_t aligned(size_t offset) { return (offset + kSectionAlignment - 1) / kSectionAlignment * kSectionAlignment; }

/// Checksum of the header up to its checksum field, and of the table behind it.
uint64_t headerChecksum(const std::byte* bytes)
{
	std::vector<std::byte> covered(bytes, bytes + kChecksumOffset);
	covered.insert(covered.end(), bytes + kHeaderBytes, bytes + kTableEnd);
	return checksum64(covered.data(), covered.size());
}

Error cutShort(size_t have, uint64_t want)
{
	return {"the file is cut short: it has " + std::to_string(have) + " bytes of at least " + std::to_string(want) +
		"; copy or build it again"};
}

Error damaged(const std::string& what) { return {"the file is damaged: " + what + "; copy or build it again"}; }

/// Checks magic, version, section count, table and file size. The message is empty if all are correct.
Error checkHeader(const std::byte* bytes, size_t size)
{
	if (size > 0 && std::memcmp(bytes, kMagic, std::min(size, sizeof kMagic)) != 0) return {"this is not an inner sphere tree (.ist) file"};
	if (size < kHeaderBytes) return cutShort(size, kHeaderBytes);
	ByteReader r(bytes + sizeof kMagic, kHeaderBytes - sizeof kMagic);
	const uint32_t version = r.u32();
	if (version > kAssetVersion)
		return {"written by a newer version (" + std::to_string(version) + "), this library reads up to " + std::to_string(kAssetVersion) +
			"; build the file again or update the library"};
	if (version < kAssetVersion)
		return {"it is of format version " + std::to_string(version) + " of BulletHaptics " + kLastOfOlderFormats +
			" or older; rebuild it: ist build MESH -o FILE"};
	const uint32_t count = r.u32();
	const uint64_t fileSize = r.u64();
	const uint64_t stored = r.u64();
	if (count != kSectionCount) return damaged("wrong number of sections (" + std::to_string(count) + ")");
	if (size < kTableEnd) return cutShort(size, kTableEnd);
	if (headerChecksum(bytes) != stored) return damaged("checksum mismatch in the header");
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
	bool whole = false;  ///< the section has this checksum
	SectionState state = SectionState::Bad;
};

Error readTable(const std::byte* bytes, size_t size, std::vector<Section>& sections)
{
	ByteReader table(bytes + kHeaderBytes, kSectionCount * kTableEntryBytes);
	uint64_t end = kTableEnd;
	for (uint32_t id = 1; id < kSectionEnd; ++id)
	{
		const uint32_t storedId = table.u32(), reserved = table.u32();
		const uint64_t offset = table.u64(), length = table.u64(), stored = table.u64();
		const bool inPlace = storedId == id && reserved == 0 && offset == aligned(end) && offset <= size && length <= size - offset;
		if (!inPlace || std::any_of(bytes + end, bytes + offset, [](std::byte b) { return b != std::byte{}; }))
			return damaged(std::string("the ") + sectionName(id) + " section is not where it should be");
		sections.push_back({id, bytes + offset, static_cast<size_t>(length), stored});
		end = offset + length;
	}
	return end == size ? Error{} : damaged("its sections do not fill it");
}

std::string problemOf(const Section& section)
{
	if (!section.whole) return std::string("checksum mismatch in the ") + sectionName(section.id) + " section";
	if (section.state == SectionState::Bad) return std::string("the ") + sectionName(section.id) + " section contradicts itself";
	return {};
}

bool isLength(double value) { return std::isfinite(value) && value >= 0; }

/// Quick test whether the mass section satisfies `InnerSphereTree::validate`.
bool massHolds(const InnerSphereTree& tree)
{
	for (int i = 0; i < 3; ++i)
		if (!isFinite(tree.inertia.row(i))) return false;
	for (double length : {tree.volume, tree.area, tree.meanGap, tree.maxGap, tree.uncoveredArea, tree.fill, tree.resolution, tree.sagitta})
		if (!isLength(length)) return false;
	if (!std::all_of(tree.calibration.begin(), tree.calibration.end(), isLength)) return false;
	return isFinite(tree.origin) && tree.volume > 0;
}

std::string readSections(const std::shared_ptr<const void>& owner, std::vector<Section>& sections, InnerSphereTree& tree)
{
	const int trees = kLawSection - 1, end = kSectionEnd - 1;
	const auto sum = [](Section& s) { s.whole = checksum64(s.bytes, s.size) == s.checksum; };
	const auto decode = [&](Section& s) {
		populate(s.bytes, s.size);
		s.state = decodeSection(s.id, owner, s.bytes, s.size, tree);
	};
	for (int i = 0; i < trees; ++i)
	{
		decode(sections[i]);
		sum(sections[i]);
		if (const std::string problem = problemOf(sections[i]); !problem.empty()) return problem;
	}
	// Each section fills a part of its own, and decoding is safe for any bytes. The longest section comes first.
	[[maybe_unused]] const bool large = tree.spheres.size() > 10000;
#pragma omp parallel if (large)
	{
#pragma omp for schedule(dynamic, 1) nowait
		for (int i = trees; i < end; ++i) decode(sections[i]);
#pragma omp for schedule(dynamic, 1)
		for (int i = trees; i < end; ++i) sum(sections[i]);
	}
	bool doubtful = !massHolds(tree);
	for (const Section& section : sections)
	{
		if (const std::string problem = problemOf(section); !problem.empty()) return problem;
		doubtful |= section.state != SectionState::Good;
	}
	if (const std::string problem = describedViolation(tree); !problem.empty()) return problem;
	return doubtful ? tree.validate() : std::string();
}

/// Decodes without copying: the tree's arrays stay in `bytes`, which `owner` keeps alive.
Result<InnerSphereTree> decodeInPlace(const std::shared_ptr<const void>& owner, const std::byte* bytes, size_t size)
{
	if (const Error error = checkHeader(bytes, size); !error.message.empty()) return error;
	std::vector<Section> sections;
	if (const Error error = readTable(bytes, size, sections); !error.message.empty()) return error;
	InnerSphereTree tree;
	if (const std::string problem = readSections(owner, sections, tree); !problem.empty()) return damaged(problem);
	return tree;
}
}  // namespace

std::vector<std::byte> encodeAsset(const InnerSphereTree& tree)
{
	ByteWriter table, file;
	file.append(std::vector<std::byte>(kTableEnd));
	for (uint32_t id = 1; id < kSectionEnd; ++id)
	{
		const std::vector<std::byte> section = encodeSection(id, tree);
		file.align(kSectionAlignment);
		table.u32(id);
		table.u32(0);
		table.u64(file.size());
		table.u64(section.size());
		table.u64(checksum64(section.data(), section.size()));
		file.append(section);
	}
	ByteWriter header;
	for (unsigned char c : kMagic) header.u8(c);
	header.u32(kAssetVersion);
	header.u32(kSectionCount);
	header.u64(file.size());
	header.u64(0);
	header.append(table.bytes());
	std::vector<std::byte> bytes = file.take();
	std::copy(header.bytes().begin(), header.bytes().end(), bytes.begin());
	ByteWriter sum;
	sum.u64(headerChecksum(bytes.data()));
	std::copy(sum.bytes().begin(), sum.bytes().end(), bytes.begin() + kChecksumOffset);
	return bytes;
}

Result<InnerSphereTree> decodeAsset(const std::byte* bytes, size_t size)
{
	if (isArchive(bytes, size)) return decodeArchive(bytes, size);
	const std::shared_ptr<std::byte> copy = makeAlignedBytes(size);
	if (!copy) return Error{"not enough memory for the " + std::to_string(size) + " bytes of the asset"};
	std::copy(bytes, bytes + size, copy.get());
	return decodeInPlace(copy, copy.get(), size);
}

Result<size_t> saveAsset(const InnerSphereTree& tree, const std::string& path, const Progress& progress)
{
	const std::vector<std::byte> bytes = encodeAsset(tree);
	return writeFileAtomically(path, bytes.data(), bytes.size(), progress);
}

Result<InnerSphereTree> loadAsset(const std::string& path)
{
	Result<MappedFile> opened = MappedFile::open(path);
	if (!opened) return opened.error();
	const auto file = std::make_shared<const MappedFile>(std::move(opened).value());
	Result<InnerSphereTree> tree = isArchive(file->bytes(), file->size()) ? decodeArchive(file->bytes(), file->size())
																		  : decodeInPlace(file, file->bytes(), file->size());
	if (!tree) return Error{"\"" + path + "\": " + tree.error().message};
	return tree;
}
}  // namespace ist
