// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Asset/ByteStream.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

#include <cstddef>
#include <memory>
#include <vector>

namespace ist
{
/// Sections of an `.ist` file, in their order in it. Numbers are public: they stand in files.
enum AssetSection : uint32_t
{
	kMassSection = 1,
	kProvenanceSection,
	kSphereSection,
	kLawSection,
	kCellSection,
	kInnerSection,
	kSectionEnd
};

const char* sectionName(uint32_t id);

/// Sections, and the arrays in them, begin at multiples of so many bytes of the file: a cache line.
constexpr size_t kSectionAlignment = 64;

/// The bytes of a section as this version writes it. A tree is the numbers of its nodes and blocks, then the arrays of nodes, balls and
/// ellipsoids, of the inner tree nodes, balls and their indices: words of 32 or 16 bits in the order of the members.
std::vector<std::byte> encodeSection(uint32_t id, const InnerSphereTree& tree);
enum class SectionState
{
	Bad,       ///< does not have the size that it states, or names a sphere that is not there
	Doubtful,  ///< read; whether its tree is valid is for `BallTree::validate` to say
	Good
};
/// The arrays of `tree` stay where they are in `bytes`, which begin at a multiple of kSectionAlignment and live as long as `owner`. The
/// sphere section must have been decoded before the trees.
SectionState decodeSection(
	uint32_t id, const std::shared_ptr<const void>& owner, const std::byte* bytes, size_t size, InnerSphereTree& tree);

void writeMass(ByteWriter& w, const InnerSphereTree& tree);
void readMass(ByteReader& r, InnerSphereTree& tree);
/// Empty when the bounding box is finite and the unit positive, else the violation: `InnerSphereTree::validate` does not ask.
std::string describedViolation(const InnerSphereTree& tree);
void writeProvenance(ByteWriter& w, const InnerSphereTree::Provenance& provenance);
void readProvenance(ByteReader& r, InnerSphereTree::Provenance& provenance);
}  // namespace ist
