// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/TexturedMesh.h"

#include <cstddef>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

namespace ist
{
/// One end of the pipe from the importer program to the process that wants the mesh. Both run on one machine and are of one release, so
/// numbers are sent as they lie in memory. Functions return false if the other end is closed, or if what arrives cannot be right.
class ImportPipe
{
public:
	/// What the next bytes are.
	enum class Part : unsigned char
	{
		Fraction,  ///< of the file that was read, a double
		Failure,   ///< a sentence; nothing follows
		Surface    ///< a mesh; nothing follows
	};

	/// Takes the file descriptor, and closes it.
	explicit ImportPipe(int file) : m_file(file) {}
	~ImportPipe() { close(); }
	ImportPipe(const ImportPipe&) = delete;
	ImportPipe& operator=(const ImportPipe&) = delete;
	void close();

	bool sendFraction(double fraction) { return send(Part::Fraction) && send(fraction); }
	bool sendFailure(const std::string& sentence) { return send(Part::Failure) && sendArray(sentence); }
	bool sendSurface(const TexturedMesh& textured);

	/// Whether the next receive will not block, because data has arrived or the other end is closed. Waits at most this long.
	bool waits(int milliseconds) const;
	bool receivePart(Part& part) { return receive(part); }
	bool receiveFraction(double& fraction) { return receive(fraction); }
	bool receiveFailure(std::string& sentence) { return receiveArray(sentence); }
	/// False also for triangles whose corners do not exist.
	bool receiveSurface(TexturedMesh& textured);

private:
	bool sendBytes(const void* data, std::size_t size);
	bool receiveBytes(void* data, std::size_t size);
	template <class T> bool send(const T& value)
	{
		static_assert(std::is_trivially_copyable_v<T>);
		return sendBytes(&value, sizeof value);
	}
	template <class T> bool receive(T& value)
	{
		static_assert(std::is_trivially_copyable_v<T>);
		return receiveBytes(&value, sizeof value);
	}
	template <class Array> bool sendArray(const Array& array)
	{
		return send(array.size()) && sendBytes(array.data(), array.size() * sizeof array[0]);
	}
	/// Memory grows as bytes arrive, so that a wrong size takes no more of it than was sent.
	template <class Array> bool receiveArray(Array& array);

	int m_file;
};
}  // namespace ist
