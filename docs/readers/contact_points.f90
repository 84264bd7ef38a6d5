! Points of contact from NAME_contacts.csv of `thermoroll conicity`, linear between the lateral shifts.
! contact_points NAME_contacts.csv SIDE SHIFT_MM prints the other columns in the order of the header; empty cells are NaN.
program contact_points
  use, intrinsic :: ieee_arithmetic
  implicit none
  integer, parameter :: columns = 13
  character(len=1024) :: path, side, word, line
  character(len=64) :: cell(columns)
  real(8) :: shift, row(columns), before(columns), part
  integer :: k, unit, status
  logical :: known = .false.
  call get_command_argument(1, path)
  call get_command_argument(2, side)
  call get_command_argument(3, word)
  read (word, *) shift
  open (newunit=unit, file=trim(path), status='old', action='read')
  read (unit, '(a)') line
  do
    read (unit, '(a)', iostat=status) line
    if (status /= 0) exit
    do k = 1, columns
      status = index(trim(line)//',', ',')
      cell(k) = line(:status - 1)
      line = line(status + 1:)
    end do
    if (trim(cell(2)) /= trim(side)) cycle
    row = ieee_value(shift, ieee_quiet_nan)
    do k = 1, columns
      if (k /= 2 .and. len_trim(cell(k)) > 0) read (cell(k), *) row(k)
    end do
    if (known .and. row(1) >= shift) then
      part = (shift - before(1))/(row(1) - before(1))
      row = (1 - part)*before + part*row
      write (*, '(11(es16.8))') row(3:)
      stop
    end if
    before = row
    known = .true.
  end do
  stop 'the shift is beyond the table'
end program contact_points
