! Points of contact from NAME_contacts.csv of `thermoroll conicity`, linear between the lateral shifts.
! contact_points NAME_contacts.csv SIDE SHIFT_MM prints the other columns in the order of the header; empty cells are NaN.
program contact_points
  use, intrinsic :: ieee_arithmetic
  implicit none
  character(len=1024) :: path, side, word, line, name
  real(8) :: shift, row(13), before(13)
  integer :: unit, status
  call get_command_argument(1, path)
  call get_command_argument(2, side)
  call get_command_argument(3, word)
  read (word, *) shift
  before = ieee_value(shift, ieee_quiet_nan)
  open (newunit=unit, file=trim(path), status='old', action='read')
  read (unit, '(a)') line
  do
    read (unit, '(a)', iostat=status) line
    if (status /= 0) error stop 'the shift is beyond the table'
    row = ieee_value(shift, ieee_quiet_nan)
    read (line, *) row(1), name             ! an empty cell leaves its NaN, and / ends the row
    if (name /= side) cycle
    line = trim(line)//'/'
    read (line, *) row(1), name, row(3:)
    if (row(1) >= shift .and. .not. ieee_is_nan(before(1))) exit
    before = row
  end do
  write (*, '(11(es16.8))') before(3:) + (shift - before(1))/(row(1) - before(1))*(row(3:) - before(3:))
end program contact_points
