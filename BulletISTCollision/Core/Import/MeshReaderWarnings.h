// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

namespace ist
{
/// Listens to assimp's log while it lives, for what the readers say in this thread of faces that they dropped or gave other corners.
/// Assimp's log is one for the process: where the program has its own, it goes on as before; where it has none, it gets one until the last
/// listener is gone. Listeners may live in many threads at once, and in one thread inside each other.
class MeshReaderWarnings
{
public:
	MeshReaderWarnings();
	~MeshReaderWarnings();
	MeshReaderWarnings(const MeshReaderWarnings&) = delete;
	MeshReaderWarnings& operator=(const MeshReaderWarnings&) = delete;

	/// Each once, in assimp's words.
	const std::vector<std::string>& ofFaces() const { return m_ofFaces; }

private:
	std::vector<std::string> m_ofFaces;
	std::vector<std::string>* m_outer;
};
}  // namespace ist
