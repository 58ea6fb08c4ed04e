// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

namespace ist
{
/// Listens to assimp's log during its lifetime, for messages about faces that a reader dropped or gave other corners. Assimp has one log
/// in a process, so there may be one listener at a time.
class MeshReaderWarnings
{
public:
	MeshReaderWarnings();
	~MeshReaderWarnings();
	MeshReaderWarnings(const MeshReaderWarnings&) = delete;
	MeshReaderWarnings& operator=(const MeshReaderWarnings&) = delete;

	/// The messages in assimp's words, each once.
	const std::vector<std::string>& ofFaces() const { return m_ofFaces; }

private:
	std::vector<std::string> m_ofFaces;
};
}  // namespace ist
