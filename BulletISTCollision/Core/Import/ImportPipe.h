// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/Result.h"
#include "BulletISTCollision/Core/Mesh/TexturedMesh.h"
#include "BulletISTCollision/Core/Platform/PipeEnd.h"

#include <cstddef>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

namespace ist
{
/// The messages in the pipe from the importer program to the process that wants the mesh. Both run on one machine and are of one release,
/// so numbers are sent as they lie in memory. Functions return false if the other end is closed, or if what arrives cannot be right.
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

	explicit ImportPipe(PipeEnd& end) : m_end(end) {}

	bool sendFraction(double fraction) { return send(Part::Fraction) && send(fraction); }
	bool sendFailure(const std::string& sentence) { return send(Part::Failure) && sendArray(sentence); }
	bool sendSurface(const TexturedMesh& textured);

	/// Whether the next receive will not block, because data has arrived or the other end is closed. Waits at most this long.
	bool waits(int milliseconds) const { return m_end.waits(milliseconds); }
	bool receivePart(Part& part) { return receive(part); }
	bool receiveFraction(double& fraction) { return receive(fraction); }
	bool receiveFailure(std::string& sentence) { return receiveArray(sentence); }
	/// False also for triangles whose corners do not exist.
	bool receiveSurface(TexturedMesh& textured);

private:
	template <class T> bool send(const T& value)
	{
		static_assert(std::is_trivially_copyable_v<T>);
		return m_end.send(&value, sizeof value);
	}
	template <class T> bool receive(T& value)
	{
		static_assert(std::is_trivially_copyable_v<T>);
		return m_end.receive(&value, sizeof value);
	}
	template <class Array> bool sendArray(const Array& array)
	{
		return send(array.size()) && m_end.send(array.data(), array.size() * sizeof array[0]);
	}
	/// Memory grows as bytes arrive, so that a wrong size takes no more of it than was sent.
	template <class Array> bool receiveArray(Array& array);

	PipeEnd& m_end;
};
}  // namespace ist
