// SPDX-License-Identifier: Zlib
#pragma once

#include <string>
#include <vector>

namespace ist
{
/// Listens to assimp's log during its lifetime, for messages of this thread about faces that a reader dropped or gave other corners.
/// Assimp has one log per process. A log that the program has installed goes on as before; otherwise a log exists until the last listener
/// is destroyed. Listeners may exist in many threads at once, and may be nested in one thread.
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
	std::vector<std::string>* m_outer;
};
}  // namespace ist
