// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Asset/ByteStream.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

#include <cstddef>
#include <memory>
#include <vector>

namespace ist
{
/// Sections of an `.ist` file, in their order. The numbers are part of the file format.
enum AssetSection : uint32_t
{
	kMassSection = 1,
	kProvenanceSection,
	kSphereSection,
	kLawSection,
	kCellSection,
	kInnerSection,
	kSurfaceSection,
	kSectionEnd
};

const char* sectionName(uint32_t id);

/// Sections and their arrays begin at multiples of this number of bytes in the file: a cache line.
constexpr size_t kSectionAlignment = 64;

/// The bytes of a section as this version writes it. A tree is stored as the numbers of its nodes and blocks, then its arrays: nodes,
/// balls and ellipsoids, or in the inner tree nodes, balls and their indices. They are words of 32 or 16 bits in the order of the
/// members. The surface is stored as the numbers of its nodes and elements, and of the nodes and cells of its depth field, then the field's
/// domain and margin, then these four arrays. The section of an empty surface has no bytes.
std::vector<std::byte> encodeSection(uint32_t id, const InnerSphereTree& tree);
enum class SectionState
{
	Bad,       ///< does not have the size that it states, or names a sphere that does not exist
	Doubtful,  ///< read; `InnerSphereTree::validate` must decide whether it is valid
	Good
};
/// Decodes a section. The arrays of `tree` stay in `bytes`, which must begin at a multiple of kSectionAlignment and live as long as
/// `owner`. The sphere section must be decoded before the trees.
SectionState decodeSection(
	uint32_t id, const std::shared_ptr<const void>& owner, const std::byte* bytes, size_t size, InnerSphereTree& tree);

void writeMass(ByteWriter& w, const InnerSphereTree& tree);
void readMass(ByteReader& r, InnerSphereTree& tree);
/// Empty if the bounding box is finite and the unit positive; otherwise the violation. `InnerSphereTree::validate` does not check these.
std::string describedViolation(const InnerSphereTree& tree);
void writeProvenance(ByteWriter& w, const InnerSphereTree::Provenance& provenance);
void readProvenance(ByteReader& r, InnerSphereTree::Provenance& provenance);
}  // namespace ist
