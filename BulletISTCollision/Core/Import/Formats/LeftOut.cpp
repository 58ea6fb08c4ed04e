// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/Formats/LeftOut.h"

namespace ist
{
std::string counted(int64_t n, const char* thing) { return std::to_string(n) + " " + thing + (n == 1 ? "" : "s"); }

bool LeftOut::takes(size_t corners, bool isValid)
{
	points += corners == 1;
	lines += corners == 2;
	if (corners < 3) return false;
	++faces;
	if (!isValid && damaged++ == 0) firstDamaged = faces;
	return isValid;
}

std::vector<std::string> LeftOut::sentences() const
{
	std::vector<std::string> all;
	if (damaged)
		all.push_back(std::to_string(damaged) + " of " + counted(faces, "face") + " " + (damaged == 1 ? "was" : "were") +
			" left out: they name corners that are not in the file, the first is face " + std::to_string(firstDamaged) +
			"; export the mesh again.");
	const std::string both = lines && points ? " and " : "";
	if (lines || points)
		all.push_back((lines ? counted(lines, "line") : "") + both + (points ? counted(points, "point") : "") +
			(lines + points == 1 ? " was" : " were") + " left out: they have no surface.");
	return all;
}

std::optional<std::string> LeftOut::tooDamaged() const
{
	if (2 * damaged <= faces) return std::nullopt;
	return std::to_string(damaged) + " of its " + counted(faces, "face") + " name corners that are not in the file, the first is face " +
		std::to_string(firstDamaged) + "; export the mesh again";
}
}  // namespace ist
