// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/ByteStream.h"
#include "BulletISTCollision/Core/InnerSphereTree.h"

#include <cstddef>
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

/// The bytes of a section as this version writes it. A tree is its nodes (lanes x, y, z, r, child), the head of each block
/// (count, bound) and sixteen balls for each block. Of a ball of the inner tree only the index of its sphere is stored.
std::vector<std::byte> encodeSection(uint32_t id, const InnerSphereTree& tree);
enum class SectionState
{
	Bad,       ///< does not have the size that it states, or names a sphere that is not there
	Doubtful,  ///< read; whether its tree is valid is for `BallTree::validate` to say
	Good
};
/// The sphere section must have been decoded before the trees.
SectionState decodeSection(uint32_t id, const std::byte* bytes, size_t size, InnerSphereTree& tree);
/// The same of version 1: blocks with copies of their balls, whole balls for the inner tree.
SectionState decodeSectionVersion1(uint32_t id, const std::byte* bytes, size_t size, InnerSphereTree& tree);

void writeMass(ByteWriter& w, const InnerSphereTree& tree);
void readMass(ByteReader& r, InnerSphereTree& tree);
/// Empty when the bounding box is finite and the unit positive, else the violation: `InnerSphereTree::validate` does not ask.
std::string describedViolation(const InnerSphereTree& tree);
void writeProvenance(ByteWriter& w, const InnerSphereTree::Provenance& provenance);
void readProvenance(ByteReader& r, InnerSphereTree::Provenance& provenance);
}  // namespace ist
