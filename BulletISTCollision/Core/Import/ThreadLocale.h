// SPDX-License-Identifier: Zlib
#pragma once

#include <locale.h>
#ifdef __APPLE__
#include <xlocale.h>
#endif

namespace ist
{
/// While it lives, this thread reads and writes numbers in another locale; other threads, and the locale of the program, stay as they are.
class ThreadLocale
{
public:
	explicit ThreadLocale(locale_t locale) : m_before(uselocale(locale)) {}
	~ThreadLocale() { uselocale(m_before); }
	ThreadLocale(const ThreadLocale&) = delete;
	ThreadLocale& operator=(const ThreadLocale&) = delete;

	locale_t before() const { return m_before; }

private:
	locale_t m_before;
};

/// The locale "C", in which numbers have a point and letters are those of ASCII.
class PlainLocale
{
public:
	PlainLocale() : m_locale(newlocale(LC_ALL_MASK, "C", nullptr)) {}
	~PlainLocale()
	{
		if (m_locale) freelocale(m_locale);
	}
	PlainLocale(const PlainLocale&) = delete;
	PlainLocale& operator=(const PlainLocale&) = delete;

	/// Null where there is no memory for it; a ThreadLocale of null changes nothing.
	locale_t get() const { return m_locale; }

private:
	locale_t m_locale;
};
}  // namespace ist
