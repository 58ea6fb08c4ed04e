// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/MeshFileUnit.h"

#include "BulletISTCollision/Core/Import/Formats/MeshText.h"
#include "BulletISTCollision/Core/Import/Formats/ObjForAssimp.h"
#include "BulletISTCollision/Core/Import/Formats/XmlTags.h"
#include "BulletISTCollision/Core/Import/Formats/ZipArchive.h"
#include "BulletISTCollision/Core/Mesh/MeshDiagnostics.h"
#include "BulletISTCollision/Core/Platform/Utf8Path.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string_view>
#include <utility>

namespace ist
{
namespace
{
struct NamedUnit
{
	std::string_view name;
	double metres;
};
// Sources: 3MF core specification, 3.4.1, and ISO/ASTM 52915 with spellings that occur in AMF files. Files of both formats that state no
// unit are in millimetres.
constexpr NamedUnit kUnitsOf3mf[] = {
	{"micron", 1e-6}, {"millimeter", 1e-3}, {"centimeter", 1e-2}, {"inch", 0.0254}, {"foot", 0.3048}, {"meter", 1}};
constexpr NamedUnit kUnitsOfAmf[] = {{"micron", 1e-6}, {"microns", 1e-6}, {"micrometer", 1e-6}, {"millimeter", 1e-3}, {"millimeters", 1e-3},
	{"mm", 1e-3}, {"centimeter", 1e-2}, {"centimeters", 1e-2}, {"cm", 1e-2}, {"inch", 0.0254}, {"inches", 0.0254}, {"in", 0.0254},
	{"foot", 0.3048}, {"feet", 0.3048}, {"ft", 0.3048}, {"meter", 1}, {"meters", 1}, {"m", 1}};
constexpr double kMillimetre = 1e-3;

/// The text in lower case, without surrounding blanks.
std::string plain(std::string text)
{
	const auto isBlank = [](unsigned char c) { return std::isspace(c) != 0; };
	text.erase(text.begin(), std::find_if_not(text.begin(), text.end(), isBlank));
	text.erase(std::find_if_not(text.rbegin(), text.rend(), isBlank).base(), text.end());
	std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
	return text;
}

MeshFileUnit namedUnit(const char* format, std::span<const NamedUnit> units, const std::optional<std::string>& stated)
{
	const std::string name = plain(stated.value_or(""));
	if (name.empty()) return {format, "", kMillimetre, false};
	const auto unit = std::find_if(units.begin(), units.end(), [&](const NamedUnit& u) { return u.name == name; });
	return {format, *stated, unit == units.end() ? 0 : unit->metres, false};
}

/// The unit of a COLLADA file. Like assimp, it accepts numbers with a decimal comma.
MeshFileUnit unitOfCollada(XmlTags& tags)
{
	bool inAsset = false;
	while (tags.next())
	{
		if (tags.depth() <= 2) inAsset = tags.depth() == 2 && tags.name() == "asset";
		if (!inAsset || tags.depth() != 3 || tags.name() != "unit") continue;
		const std::optional<std::string> stated = tags.attribute("meter");
		std::string number = plain(stated.value_or(""));
		if (number.empty()) break;
		if (number.front() == '+') number.erase(0, 1);
		std::replace(number.begin(), number.end(), ',', '.');
		double metres = 0;
		const std::from_chars_result end = std::from_chars(number.data(), number.data() + number.size(), metres);
		if (end.ec != std::errc() || !std::isfinite(metres) || metres < 0) metres = 0;
		return {"COLLADA", *stated, metres, true};
	}
	return {"COLLADA", "", 1, true};
}

MeshFileUnit unitOfXml(std::string_view text)
{
	XmlTags tags(text);
	if (!tags.next()) return {};
	if (tags.name() == "amf") return namedUnit("AMF", kUnitsOfAmf, tags.attribute("unit"));
	if (tags.name() == "COLLADA") return unitOfCollada(tags);
	return {};
}

/// The text of an AMF file with a unit that assimp's reader does not refuse: it ignores the unit, but takes five names only. Empty optional
/// if the text is as it should be.
std::optional<std::string> amfForAssimp(std::string_view text, const MeshFileUnit& unit)
{
	constexpr std::string_view kTaken[] = {"inch", "millimeter", "meter", "feet", "micron"};
	if (unit.format != "AMF" || unit.stated.empty() || std::find(std::begin(kTaken), std::end(kTaken), unit.stated) != std::end(kTaken))
		return std::nullopt;
	XmlTags tags(text);
	tags.next();
	const size_t end = tags.position(), begin = text.substr(0, end).rfind('<');
	for (const char quote : {'"', '\''})
		if (const size_t at = text.substr(0, end).find(quote + unit.stated + quote, begin); at != text.npos)
			return std::string(text.substr(0, at + 1)).append("meter").append(text.substr(at + 1 + unit.stated.size()));
	return std::nullopt;
}

Result<MeshFileHead> headOfArchive(const std::string& path, const ZipArchive& archive)
{
	const std::string ending = meshFileEnding(path);
	if (const auto& names = archive.names(); std::find(names.begin(), names.end(), "[Content_Types].xml") != names.end())
		return Error{"cannot read " + path + ": it is an archive of the kind of 3MF files; if it is one, let its name end with .3mf"};
	// Assimp ends the process on a file whose checksum is wrong. We give it the text of an AMF file, so that it opens no archive there.
	// Each file is checked by its index, because two may have the same name.
	for (size_t i = 0; i < archive.names().size() && ending != ".amf"; ++i)
		if (const std::string& other = archive.names()[i]; !other.empty() && other.back() != '/' && !archive.read(i))
			return Error{"cannot read " + path + ": \"" + other +
				"\" in it is damaged, or packed in a way that is not known; export the mesh again"};
	for (const std::string& name : archive.names())
	{
		const bool isCollada = ending == ".zae" && plain(name).ends_with(".dae");
		const bool isAmf = ending == ".amf" && (plain(name).ends_with(".amf") || archive.names().size() == 1);
		if (!isCollada && !isAmf) continue;
		std::optional<std::string> text = archive.read(name);
		if (!text) return Error{"cannot read " + path + ": \"" + name + "\" in it is damaged; export the mesh again"};
		const MeshFileUnit unit = unitOfXml(*text);
		if (std::optional<std::string> taken = amfForAssimp(*text, unit)) text = std::move(taken);
		return MeshFileHead{unit, isCollada ? std::nullopt : std::move(text)};
	}
	return MeshFileHead{};
}

/// The content of a file; empty optional if it cannot be read. Assimp then reports the reason.
std::optional<std::string> contentOf(const std::string& path)
{
	std::error_code failure;
	if (!std::filesystem::is_regular_file(systemPath(path), failure)) return std::nullopt;
	std::ifstream file(systemPath(path), std::ios::binary);
	char head[4] = {};
	file.read(head, sizeof head);
	const std::string_view start(head, static_cast<size_t>(file.gcount()));
	const size_t first = start.find_first_not_of(" \t\r\n");
	const bool isXml = first != start.npos && (start[first] == '<' || needsUtf8(start));
	const std::string ending = meshFileEnding(path);
	if (!isXml && !start.starts_with("PK") && ending != ".zae" && ending != ".obj" && ending != ".ply") return std::nullopt;
	file.clear();
	file.seekg(0);
	std::string content(std::filesystem::file_size(systemPath(path), failure), '\0');
	file.read(content.data(), static_cast<std::streamsize>(content.size()));
	content.resize(static_cast<size_t>(file.gcount()));
	return content;
}
}  // namespace

MeshFileUnit unitOf3mf(const std::optional<std::string>& stated) { return namedUnit("3MF", kUnitsOf3mf, stated); }

Result<Scale> scaleOf(const std::string& path, const MeshFileUnit& file, const std::optional<double>& given)
{
	// Tolerance for units in text, which have few digits.
	constexpr double kSame = 1e-6;
	if (!(file.metres > 0) && (!given || file.appliedByReader))
		return Error{path + ": it states \"" + file.stated + "\" as its unit, which is none of " + file.format + " files; correct it" +
			(file.appliedByReader ? "" : ", or pass its unit to importMesh()")};
	const double applied = file.appliedByReader ? file.metres : 1;
	if (!given) return Scale{file.metres, file.metres / applied, {}};
	if (std::fabs(*given - file.metres) <= kSame * file.metres) return Scale{file.metres, file.appliedByReader ? 1 : *given, {}};
	Scale scale{*given, *given / applied, {}};
	const std::string states = file.stated.empty()
		? "The file states no unit, for which the " + file.format + " format has " + lengthWords(file.metres)
		: file.appliedByReader
		? "The file states " + lengthWords(file.metres) + " as its unit"
		: "The file states \"" + file.stated + "\" as its unit" + (file.metres > 0 ? ", " + lengthWords(file.metres) : "");
	if (!file.format.empty()) scale.notTaken = states + "; in its place the given unit was applied, " + lengthWords(*given) + ".";
	return scale;
}

std::string lengthWords(double metres) { return number(metres) + " m"; }

std::string meshFileEnding(const std::string& path) { return plain(utf8Path(systemPath(path).extension())); }

Result<MeshFileHead> readMeshFileHead(const std::string& path)
{
	const std::optional<std::string> content = contentOf(path);
	return content ? meshFileHead(path, *content) : MeshFileHead{};
}

Result<MeshFileHead> meshFileHead(const std::string& path, std::string_view content)
{
	const std::string ending = meshFileEnding(path);
	if (ending == ".obj")
	{
		Result<std::optional<std::string>> text = objForAssimp(content);
		if (!text) return Error{"cannot read " + path + ": " + text.error().message};
		return MeshFileHead{{}, std::move(text).value()};
	}
	if (const std::optional<ZipArchive> archive = ZipArchive::open(content)) return headOfArchive(path, *archive);
	if (content.starts_with("PK\3\4")) return Error{"cannot read " + path + ": its archive is damaged; export the mesh again"};
	std::optional<std::string> text = needsUtf8(content) ? std::optional(utf8Text(content)) : std::nullopt;
	const MeshFileUnit unit = unitOfXml(text ? *text : content);
	if (std::optional<std::string> taken = amfForAssimp(text ? *text : content, unit)) text = std::move(taken);
	return MeshFileHead{unit, std::move(text)};
}
}  // namespace ist
