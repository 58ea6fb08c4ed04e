// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ist
{
enum class PlyType
{
	Int8,
	Uint8,
	Int16,
	Uint16,
	Int32,
	Uint32,
	Float,
	Double
};

struct PlyProperty
{
	std::string name;
	PlyType type = PlyType::Float;     ///< of the value, or of each item of a list
	std::optional<PlyType> countType;  ///< of the number of items; only lists have it
};

struct PlyElement
{
	std::string name;
	uint64_t count = 0;
	std::vector<PlyProperty> properties;
};

struct PlyHeader
{
	enum class Format
	{
		Ascii,
		Little,
		Big
	} format = Format::Ascii;
	std::vector<PlyElement> elements;
	size_t end = 0;  ///< position of the first byte behind the header
};

/// Reads the header of a PLY file in UTF-8 without a byte order mark. Errors: see readPly().
Result<PlyHeader> readPlyHeader(std::string_view text);
}  // namespace ist
