// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Hand/BvhHand.h"

#include "BulletISTCollision/Core/Platform/MappedFile.h"
#include "DeviceBridge/Hand/HandFromPoints.h"
#include "DeviceBridge/Hand/HandParts.h"

#include <charconv>
#include <cmath>
#include <string_view>

using namespace ist;

namespace devicebridge
{
namespace
{
constexpr double kDegree = 0.017453292519943295;
constexpr double kMostFrames = 1e7;
constexpr const char* kFingers[kHandFingers] = {"Thumb", "Index", "Middle", "Ring", "Pinky"};
constexpr const char* kChannels[6] = {"Xposition", "Yposition", "Zposition", "Xrotation", "Yrotation", "Zrotation"};

struct Node
{
	std::string name;  // empty for an end site
	int parent = -1;
	Vec3 offset;
	std::vector<int> channels;
};

class BvhReader
{
public:
	BvhReader(const std::string& text, const std::string& name) : m_rest(text), m_name(name) {}

	bool readHierarchy()
	{
		expect("HIERARCHY");
		expect("ROOT");
		int open = -1;
		begin(open, std::string(word()));
		while (open >= 0 && !m_problem)
		{
			const std::string_view key = word();
			if (key == "OFFSET")
				for (int a = 0; a < 3; ++a) m_nodes[size_t(open)].offset[a] = number();
			else if (key == "CHANNELS") readChannels(m_nodes[size_t(open)]);
			else if (key == "JOINT") begin(open, std::string(word()));
			else if (key == "End") expect("Site"), begin(open, "");
			else if (key == "}") open = m_nodes[size_t(open)].parent;
			else refuse("'" + std::string(key) + "' is nothing that a joint has");
		}
		for (const Node& node : m_nodes) m_channels += node.channels.size();
		if (m_channels == 0) refuse("no joint has a channel");
		return !m_problem;
	}
	bool readMotion()
	{
		expect("MOTION");
		expect("Frames:");
		const double frames = number();
		expect("Frame");
		expect("Time:");
		m_frameTime = number();
		if (!(frames >= 1 && frames <= kMostFrames) || frames != std::floor(frames))
			refuse("the number of frames must be whole and positive");
		if (!(m_frameTime > 0)) refuse("the frame time must be positive");
		if (!lineEnds()) refuse("there is more on the line of the frame time");
		m_frames = m_problem ? 0 : size_t(frames);
		return !m_problem;
	}
	/// Reads the next frame, which is one line. Returns the positions of all nodes, in the file's units.
	std::vector<Vec3> readFrame()
	{
		const std::vector<double> row = readRow();
		size_t next = 0;
		std::vector<Pose> poses(m_nodes.size());
		std::vector<Vec3> places;
		for (size_t i = 0; i < m_nodes.size() && !m_problem; ++i)
		{
			const Node& node = m_nodes[i];
			Pose X{{}, node.offset};
			for (const int channel : node.channels)
			{
				const double value = row[next++];
				if (channel < 3)
				{
					X.translation[channel] = value;
					continue;
				}
				Vec3 turn;
				turn[channel - 3] = kDegree * value;
				X.rotation = X.rotation * rotationMatrix(quaternionFromRotationVector(turn));
			}
			poses[i] = node.parent < 0 ? X : poses[size_t(node.parent)] * X;
			places.push_back(poses[i].translation);
		}
		return places;
	}
	void expectEnd()
	{
		while (lineEnds() && !m_rest.empty())
		{
			m_rest.remove_prefix(1);
			++m_line;
		}
		if (!m_rest.empty()) refuse("'" + std::string(word()) + "' after the last frame");
	}
	/// The first node of that name, or else the end site below the node `otherwise`; -1 if neither exists.
	int find(const std::string& name, int otherwise = -1) const
	{
		for (size_t i = 0; i < m_nodes.size(); ++i)
		{
			const std::string& own = m_nodes[i].name;
			if (!own.empty() && own.substr(own.rfind(':') + 1) == name) return int(i);
		}
		for (size_t i = 0; otherwise >= 0 && i < m_nodes.size(); ++i)
			if (m_nodes[i].name.empty() && m_nodes[i].parent == otherwise) return int(i);
		return -1;
	}
	void refuse(const std::string& problem)
	{
		if (!m_problem) m_problem = Error{m_name + ":" + std::to_string(m_line) + ": " + problem};
	}
	const std::optional<Error>& problem() const { return m_problem; }
	size_t frames() const { return m_frames; }
	double frameTime() const { return m_frameTime; }

private:
	std::string_view word()
	{
		size_t i = 0;
		while (i < m_rest.size() && (m_rest[i] == ' ' || m_rest[i] == '\t' || m_rest[i] == '\r' || m_rest[i] == '\n'))
			m_line += m_rest[i++] == '\n';
		size_t end = i;
		while (end < m_rest.size() && m_rest[end] != ' ' && m_rest[end] != '\t' && m_rest[end] != '\r' && m_rest[end] != '\n') ++end;
		const std::string_view found = m_rest.substr(i, end - i);
		m_rest.remove_prefix(end);
		if (found.empty()) refuse("the file ends too early");
		return found;
	}
	void expect(const char* what)
	{
		const std::string_view found = word();
		if (found != what) refuse("'" + std::string(found) + "' where " + what + " should be");
	}
	double number()
	{
		const std::string_view text = word();
		double value = 0;
		const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
		if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
			refuse("'" + std::string(text) + "' is not a finite number");
		return value;
	}
	/// Skips blanks. Returns whether the line ends there.
	bool lineEnds()
	{
		const size_t blanks = m_rest.find_first_not_of(" \t\r");
		m_rest.remove_prefix(blanks == std::string_view::npos ? m_rest.size() : blanks);
		return m_rest.empty() || m_rest.front() == '\n';
	}
	/// The numbers of the next line that is not blank, one per channel.
	std::vector<double> readRow()
	{
		std::vector<double> row;
		do row.push_back(number());
		while (!m_problem && !lineEnds());
		if (row.size() != m_channels)
			refuse("a frame has " + std::to_string(m_channels) + " numbers, and here are " + std::to_string(row.size()));
		return row;
	}
	void begin(int& open, const std::string& name)
	{
		expect("{");
		m_nodes.push_back({name, open, {}, {}});
		open = int(m_nodes.size()) - 1;
	}
	void readChannels(Node& node)
	{
		const double count = number();
		for (int i = 0; i < count && !m_problem; ++i)
		{
			const std::string_view name = word();
			int channel = 0;
			while (channel < 6 && name != kChannels[channel]) ++channel;
			if (channel == 6) refuse("'" + std::string(name) + "' is no channel");
			else node.channels.push_back(channel);
		}
	}

	std::string_view m_rest;
	const std::string& m_name;
	int m_line = 1;
	std::vector<Node> m_nodes;
	size_t m_channels = 0, m_frames = 0;
	double m_frameTime = 0;
	std::optional<Error> m_problem;
};

/// The node of each point of the hand.
std::array<int, kHandPoints> findPoints(BvhReader& reader, const BvhHandOptions& options)
{
	const std::string wrist = !options.wrist.empty() ? options.wrist : options.left ? "LeftHand" : "RightHand";
	std::array<int, kHandPoints> nodes{};
	nodes[0] = reader.find(wrist);
	if (nodes[0] < 0) reader.refuse("there is no joint " + wrist);
	for (int i = 1; i < kHandPoints; ++i)
	{
		const int along = (i - 1) % 4;
		const std::string joint = wrist + kFingers[(i - 1) / 4] + std::to_string(along + 1);
		nodes[size_t(i)] = reader.find(joint, along == 3 ? nodes[size_t(i - 1)] : -1);
		if (nodes[size_t(i)] < 0) reader.refuse("there is no joint " + joint);
	}
	return nodes;
}
}  // namespace

Result<HandMotion> readBvhHand(const std::string& text, const std::string& name, const BvhHandOptions& options)
{
	if (!(options.unit > 0) || !std::isfinite(options.unit)) return Error{name + ": the unit must be a positive number of metres"};
	BvhReader reader(text, name);
	if (!reader.readHierarchy()) return *reader.problem();
	const std::array<int, kHandPoints> nodes = findPoints(reader, options);
	if (reader.problem() || !reader.readMotion()) return *reader.problem();
	HandMotion motion;
	for (size_t i = 0; i < reader.frames(); ++i)
	{
		const std::vector<Vec3> places = reader.readFrame();
		if (reader.problem()) return *reader.problem();
		HandPoints points;
		for (size_t k = 0; k < kHandPoints; ++k) points[k] = options.unit * places[size_t(nodes[k])];
		Result<HandState> hand = handFromPoints(points, options.left);
		if (!hand) reader.refuse("frame " + std::to_string(i) + ": " + hand.error().message);
		if (reader.problem()) return *reader.problem();
		motion.frames.push_back({double(i) * reader.frameTime(), hand.value()});
	}
	reader.expectEnd();
	if (reader.problem()) return *reader.problem();
	return motion;
}

Result<HandMotion> loadBvhHand(const std::string& path, const BvhHandOptions& options)
{
	const Result<MappedFile> file = MappedFile::open(path);
	if (!file) return file.error();
	return readBvhHand(std::string(reinterpret_cast<const char*>(file.value().bytes()), file.value().size()), path, options);
}
}  // namespace devicebridge
