!> What the audit knows of other answers, in the reader's words (doc/manual, "The audit").
module answers_text
  use kinds, only: wp
  use text, only: to_text, count_noun
  use contact_points, only: point_text
  use model_types, only: model_t
  use audit_types, only: audit_t, check_answers
  implicit none
  private
  public :: answers_finding, answers_advice

  !> What a warning means, and what to do.
  character(*), parameter :: answers_advice = 'Coulomb''s law has several answers where '// &
    'friction pushes a point off or pulls it on, and which one a run finds depends on its '// &
    'increments: write CHECk,UNIQue behind STEP to see others, look at what led here, halve '// &
    'DT, or lower mu'

contains

  !> What is known of other answers: what is certain first.
  function answers_finding(model, audit) result(t)
    type(model_t), intent(in) :: model !! pairs
    type(audit_t), intent(in) :: audit !! an audited end time
    character(:), allocatable :: t

    associate (answers => audit%answers)
      t = 'not looked for'
      if (.not. allocated(answers%unknown)) return
      if (len(answers%unknown) > 0) t = 'not looked for: '//answers%unknown
      if (len(answers%unknown) > 0) return
      t = ''
      if (answers%sign > 0) t = 'the tangent keeps its sign'
      if (answers%sign < 0) t = 'there are at least two others: this one is unstable'
      if (answers%share > 0.0_wp) t = t//', its statuses bear '// &
        to_text(1.0_wp/answers%share, 3)//' times the friction'
      if (answers%too_many) t = 'statuses of '//to_text(answers%closed)//' points not looked at'
      if (len(t) > 0 .and. answers%point > 0) t = t//'; '
      if (answers%point > 0) t = t//'a point alone bears '// &
        to_text(1.0_wp/answers%point_share, 3)//' times the friction (slave '// &
        point_text(model%pairs(audit%worst(check_answers)), answers%point)//', pair '// &
        model%pairs(audit%worst(check_answers))%name//')'
      if (len(t) == 0) t = 'friction moves no point along its normal'
      if (answers%searched) t = t//'; '//others_text(audit)
    end associate
  end function answers_finding

  !> What second starts have found.
  function others_text(audit) result(t)
    type(audit_t), intent(in) :: audit !! an audited end time
    character(:), allocatable :: t
    integer :: k

    associate (answers => audit%answers, n => size(audit%answers%others, 2))
      t = 'second starts at '//count_noun(answers%tried, 'point')//' find '
      if (n == 0) t = t//'no other'
      do k = 1, n
        associate (other => answers%others(:, k))
          if (k > 1) t = t//', and '
          if (nint(other(1)) == 0) then
            t = t//'one without contact'
          else
            t = t//'one with '//to_text(nint(other(1)))//' closed, '//to_text(nint(other(2)))// &
              ' slipping, pressure '//to_text(other(3), 4)//', friction '//to_text(other(4), 4)
          end if
        end associate
      end do
    end associate
  end function others_text
end module answers_text
