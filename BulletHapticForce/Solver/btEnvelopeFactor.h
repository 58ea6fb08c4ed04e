// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

/// Cholesky factorisation A = L L^T of a symmetric positive definite matrix of 6 x 6 blocks, one row of blocks for each place. Row r is
/// stored from its first block that is not zero to its diagonal: this is the envelope, and elimination fills nothing outside it.
///
/// The clique of a place holds the place itself and all later places whose rows reach back to it. A back substitution needs no other place.
/// All blocks of the inverse between two members of a clique lie within the envelope, and `invert` finds them without any other block.
///
/// Cost: factorise and invert O(sum over the places of the square of the clique's size), one substitution O(blocks of the envelope). A
/// chain and a star have cliques of two. No allocation once `reserve` has seen the size.
class btEnvelopeFactor
{
public:
	static constexpr int kSide = 6, kBlock = 36;

	void reserve(int places);
	/// Begins a new envelope, which holds the diagonal only.
	void begin(int places);
	/// Two places whose block is not zero. Their order does not matter.
	void couple(int a, int b);
	/// Ends the envelope. Values may be set as often as you like from here on.
	void layOut();
	int places() const { return m_places; }
	/// The clique of `place` without the place itself, ascending.
	const int* cliqueBegin(int place) const { return m_cliques.data() + m_cliqueStart[size_t(place)]; }
	const int* cliqueEnd(int place) const { return m_cliques.data() + m_cliqueStart[size_t(place) + 1]; }
	/// Numbers within the envelope, which are those that one substitution reads.
	int64_t entries() const;
	/// Blocks within the envelope.
	int64_t blocks() const { return int64_t(m_size / kBlock); }

	/// A = I.
	void setIdentity();
	/// Adds a row-major block to A. `row` >= `column`, and both are coupled.
	void add(int row, int column, const double* block);
	/// Replaces A by L. False when A is not positive definite, or not finite.
	bool factorise();
	/// The blocks of the inverse of A that lie within the envelope. After `factorise`.
	void invert();
	/// Row-major block of the inverse, after `invert`. `row` >= `column`, and both are coupled.
	const double* inverseBlock(int row, int column) const { return m_inverse.data() + blockOf(row, column); }

	/// x becomes L^-1 x.
	void substituteForward(double* x);
	/// One step of the back substitution: the six numbers of `place` become those of L^-T x. All later members of its clique must be so
	/// already.
	void substituteBack(double* x, int place);
	void solve(double* x);

	/// Products of a block with a block or with a column, since the object was made: a measure of the work that does not depend on a clock.
	uint64_t products() const { return m_products; }

private:
	// Rows of blocks lie one behind the other, each as six dense rows of numbers. Those of the inverse lie block by block.
	int width(int place) const { return kSide * (place - m_first[size_t(place)] + 1); }
	size_t rowOf(int place) const { return m_row[size_t(place)]; }
	size_t blockOf(int row, int column) const { return m_row[size_t(row)] + size_t(kBlock) * size_t(column - m_first[size_t(row)]); }
	const double* factorBlock(int row, int column) const { return m_factor.data() + rowOf(row) + kSide * (column - m_first[size_t(row)]); }

	int m_places = 0;
	std::vector<int> m_first;        // place of the first block of each row
	std::vector<size_t> m_row;       // where each row begins
	std::vector<int> m_cliqueStart;  // one more than places
	std::vector<int> m_cliques;      // without the places themselves
	std::vector<double> m_factor;    // one over the diagonal
	std::vector<double> m_inverse;
	std::vector<double> m_quotients;  // of one column of blocks: L_mb L_bb^-1
	size_t m_size = 0;                // numbers that the rows take
	uint64_t m_products = 0;
};
