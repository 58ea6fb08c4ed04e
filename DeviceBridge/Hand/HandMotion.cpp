// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/HandMotion.h"

#include "BulletISTCollision/Core/Asset/AtomicFile.h"
#include "BulletISTCollision/Core/Platform/MappedFile.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>
#include <string_view>

using namespace ist;

namespace devicebridge
{
namespace
{
constexpr int kFields = 8;
constexpr const char* kFieldNames[kFields] = {"x", "y", "z", "qx", "qy", "qz", "qw", "r"};
constexpr const char* kJointNames[kHandJoints] = {"palm", "wrist", "thumb_metacarpal", "thumb_proximal", "thumb_distal", "thumb_tip",
	"index_metacarpal", "index_proximal", "index_intermediate", "index_distal", "index_tip", "middle_metacarpal", "middle_proximal",
	"middle_intermediate", "middle_distal", "middle_tip", "ring_metacarpal", "ring_proximal", "ring_intermediate", "ring_distal",
	"ring_tip", "little_metacarpal", "little_proximal", "little_intermediate", "little_distal", "little_tip"};

std::string columnName(int joint, int field) { return std::string(kJointNames[joint]) + "_" + kFieldNames[field]; }

/// Appends the shortest text that reads as the same number, in any locale.
void append(std::string& text, double value)
{
	char buffer[32];
	text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

std::vector<std::string_view> split(std::string_view line)
{
	std::vector<std::string_view> cells;
	while (true)
	{
		const size_t comma = line.find(',');
		std::string_view cell = line.substr(0, comma);
		while (!cell.empty() && (cell.front() == ' ' || cell.front() == '\t')) cell.remove_prefix(1);
		while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\t' || cell.back() == '\r')) cell.remove_suffix(1);
		cells.push_back(cell);
		if (comma == std::string_view::npos) return cells;
		line.remove_prefix(comma + 1);
	}
}

/// Reads one line after the other and keeps the first problem.
class Reader
{
public:
	explicit Reader(const std::string& name) : m_name(name) {}

	void header(std::string_view line)
	{
		const auto cells = split(line);
		m_width = cells.size();
		for (size_t i = 0; i < cells.size(); ++i)
			if (!m_columns.emplace(cells[i], i).second && !cells[i].empty())
				refuse(std::string(cells[i]), "the header has this column twice");
		need("time");
		need("left");
		for (int j = 0; j < kHandJoints; ++j)
			for (int f = 0; f < kFields; ++f) need(columnName(j, f));
	}
	void row(std::string_view line)
	{
		m_cells = split(line);
		if (m_cells.size() != m_width)
			return refuse("time", "the row has " + std::to_string(m_cells.size()) + " cells, and the header " + std::to_string(m_width));
		HandMotion::Frame frame;
		frame.time = number("time");
		const double left = number("left");
		if (left != 0 && left != 1) refuse("left", "must be 0 or 1");
		frame.hand.left = left == 1;
		for (int j = 0; j < kHandJoints; ++j) frame.hand.joints[size_t(j)] = joint(j);
		if (!m_motion.frames.empty() && !(frame.time > m_motion.frames.back().time)) refuse("time", "does not grow");
		m_motion.frames.push_back(frame);
	}
	void nextLine() { ++m_line; }
	bool hasHeader() const { return !m_columns.empty(); }
	const std::optional<Error>& problem() const { return m_problem; }
	HandMotion take() { return std::move(m_motion); }
	void refuse(const std::string& column, const std::string& problem)
	{
		if (!m_problem) m_problem = Error{m_name + ":" + std::to_string(m_line) + ": " + column + ": " + problem};
	}

private:
	void need(const std::string& column)
	{
		if (!m_columns.count(column)) refuse(column, "the header lacks this column");
	}
	std::string_view cell(const std::string& column) const
	{
		const auto found = m_columns.find(column);
		return found != m_columns.end() && found->second < m_cells.size() ? m_cells[found->second] : std::string_view();
	}
	double number(const std::string& column)
	{
		const std::string_view text = cell(column);
		double value = 0;
		const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
		if (text.empty()) refuse(column, "is missing");
		else if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
			refuse(column, "'" + std::string(text) + "' is not a finite number");
		return value;
	}
	HandJoint joint(int index)
	{
		int missing = 0;
		for (int f = 0; f < kFields; ++f) missing += cell(columnName(index, f)).empty();
		if (missing == kFields) return {};
		double v[kFields];
		for (int f = 0; f < kFields; ++f) v[f] = number(columnName(index, f));
		if (!isNearUnit({v[3], v[4], v[5], v[6]})) refuse(columnName(index, 6), "the quaternion is not of unit length");
		return {{v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]}, v[7], true};
	}

	const std::string& m_name;
	int m_line = 0;
	std::map<std::string, size_t, std::less<>> m_columns;
	size_t m_width = 0;
	std::vector<std::string_view> m_cells;
	HandMotion m_motion;
	std::optional<Error> m_problem;
};

std::array<double, kFields> fields(const HandJoint& joint)
{
	const Vec3& p = joint.position;
	const Quaternion& q = joint.orientation;
	return {p.x, p.y, p.z, q.x, q.y, q.z, q.w, joint.radius};
}

bool isSameJoint(const HandJoint& a, const HandJoint& b)
{
	if (!a.tracked || !b.tracked) return a.tracked == b.tracked;
	const auto x = fields(a), y = fields(b);
	return std::memcmp(x.data(), y.data(), sizeof x) == 0;
}

HandJoint between(const HandJoint& a, const HandJoint& b, double u)
{
	if (!a.tracked || !b.tracked) return {};
	if (isSameJoint(a, b)) return a;
	const Vec3 turn = rotationVector(b.orientation * conjugate(a.orientation));
	return {a.position + u * (b.position - a.position), quaternionFromRotationVector(u * turn) * a.orientation,
		a.radius + u * (b.radius - a.radius), true};
}
}  // namespace

HandState HandMotion::at(double time) const noexcept
{
	if (frames.empty()) return {};
	const auto after = std::upper_bound(frames.begin(), frames.end(), time, [](double t, const Frame& frame) { return t < frame.time; });
	if (after == frames.begin()) return frames.front().hand;
	if (after == frames.end()) return frames.back().hand;
	const Frame& before = *(after - 1);
	if (before.time == time) return before.hand;
	HandState hand;
	hand.left = before.hand.left;
	const double u = (time - before.time) / (after->time - before.time);
	for (size_t i = 0; i < kHandJoints; ++i) hand.joints[i] = between(before.hand.joints[i], after->hand.joints[i], u);
	return hand;
}

bool isSameHand(const HandState& a, const HandState& b) noexcept
{
	return a.left == b.left && std::equal(a.joints.begin(), a.joints.end(), b.joints.begin(), isSameJoint);
}

std::string handMotionText(const HandMotion& motion)
{
	std::string text = "time,left";
	for (int j = 0; j < kHandJoints; ++j)
		for (int f = 0; f < kFields; ++f) text += "," + columnName(j, f);
	text += "\n";
	for (const HandMotion::Frame& frame : motion.frames)
	{
		append(text, frame.time);
		text += frame.hand.left ? ",1" : ",0";
		for (const HandJoint& joint : frame.hand.joints)
		{
			for (const double value : fields(joint))
			{
				text += ",";
				if (joint.tracked) append(text, value);
			}
		}
		text += "\n";
	}
	return text;
}

std::optional<Error> saveHandMotion(const HandMotion& motion, const std::string& path)
{
	const std::string text = handMotionText(motion);
	const Result<size_t> written = writeFileAtomically(path, reinterpret_cast<const std::byte*>(text.data()), text.size());
	if (!written) return written.error();
	return std::nullopt;
}

Result<HandMotion> readHandMotion(const std::string& text, const std::string& name)
{
	Reader reader(name);
	std::string_view rest = text;
	while (!rest.empty() && !reader.problem())
	{
		const size_t end = rest.find('\n');
		const std::string_view line = rest.substr(0, end);
		rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
		reader.nextLine();
		if (line.empty() || line == "\r" || line.front() == '#') continue;
		if (reader.hasHeader()) reader.row(line);
		else reader.header(line);
	}
	if (!reader.problem() && !reader.hasHeader()) reader.refuse("time", "the file has no header");
	if (reader.problem()) return *reader.problem();
	return reader.take();
}

Result<HandMotion> loadHandMotion(const std::string& path)
{
	const Result<MappedFile> file = MappedFile::open(path);
	if (!file) return file.error();
	return readHandMotion(std::string(reinterpret_cast<const char*>(file.value().bytes()), file.value().size()), path);
}
}  // namespace devicebridge
