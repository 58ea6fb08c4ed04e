// SPDX-License-Identifier: Zlib
#pragma once

#include <optional>
#include <string>
#include <utility>

namespace ist
{
/// The reason why an offline operation failed: one sentence that says what is wrong, where, and how to correct it.
struct Error
{
	std::string message;
	bool cancelled = false;  ///< the caller's progress callback asked to stop
};

/// A value or an Error. Offline code returns this; nothing on the run-time path does.
template <class T> class [[nodiscard]] Result
{
public:
	Result(T value) : m_value(std::move(value)) {}
	Result(Error error) : m_error(std::move(error)) {}

	explicit operator bool() const { return m_value.has_value(); }
	/// Defined only when the result holds a value.
	T& value() & { return *m_value; }
	const T& value() const& { return *m_value; }
	T&& value() && { return std::move(*m_value); }
	/// Defined only when the result holds an error.
	const Error& error() const { return m_error; }

private:
	std::optional<T> m_value;
	Error m_error;
};
}  // namespace ist
